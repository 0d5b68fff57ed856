#!/usr/bin/env bash
# Files over 4 GiB: a binary STL becomes an ASCII PLY and that an STL again, with the same facets to the bit.
# (What a GLB says that would need more than 4 GiB is tested with sizes alone, in gltf_test.)
# usage: scripts/check_large.sh [FOLDER]   default: a folder in $TMPDIR; needs build/release/bin/diesink, or $DIESINK
# Needs 20 GiB of disk and 10 GiB of memory that are free, and some minutes; otherwise the script says so and ends with 0.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."
diesink=${DIESINK:-$PWD/build/release/bin/diesink}
[ -x "$diesink" ] || { echo "check_large: $diesink is missing; build it first" >&2; exit 1; }
folder=$(mktemp -d "${1:-${TMPDIR:-/tmp}}/diesink-large-XXXXXX")
trap 'rm -rf "$folder"' EXIT
disk=$(df --output=avail -k "$folder" | tail -n 1)
memory=$(awk '/MemAvailable/ {print $2}' /proc/meminfo)
if [ "$disk" -lt $((20 << 20)) ] || [ "$memory" -lt $((10 << 20)) ]; then
  echo "check_large: skipped, $((disk >> 20)) GiB of disk and $((memory >> 20)) GiB of memory are free, 20 and 10 are needed"
  exit 0
fi

# A flat sheet of 90 million triangles, row by row: 4.5 GB as STL, as much as ASCII PLY with the digits that a float's
# tenths have as doubles.
python3 - "$folder/sheet.stl" <<'PYTHON'
import struct
import sys

COLUMNS, ROWS = 9000, 5000
facet = struct.Struct("<12fH")
with open(sys.argv[1], "wb") as out:
    out.write(b"large sheet units=mm up=z".ljust(80, b"\0") + struct.pack("<I", 2 * COLUMNS * ROWS))
    # Each row is the first with another y in six places of each 100 bytes.
    row = bytearray(b"".join(
        facet.pack(0, 0, 1, i / 10, 0, 0.1, (i + 1) / 10, 0, 0.1, (i + 1) / 10, 0, 0.1, 0) +
        facet.pack(0, 0, 1, i / 10, 0, 0.1, (i + 1) / 10, 0, 0.1, i / 10, 0, 0.1, 0)
        for i in range(COLUMNS)))
    low, high = (16, 28, 66), (40, 78, 90)
    for j in range(ROWS):
        for places, y in ((low, j), (high, j + 1)):
            for place in places:
                for byte, value in enumerate(struct.pack("<f", y / 10)):
                    row[place + byte::100] = bytes([value]) * COLUMNS
        out.write(row)
PYTHON

fail() { echo "check_large: $*" >&2; exit 1; }
large() { [ "$(stat -c %s "$1")" -gt $((1 << 32)) ] || fail "$1 is no larger than 4 GiB"; }

large "$folder/sheet.stl"
if "$diesink" convert "$folder/sheet.stl" "$folder/sheet.ply" --quiet 2>"$folder/said"; then
  fail "a file over the limit was read"
fi
grep -q 'larger than the limit' "$folder/said" || fail "no word of the limit: $(cat "$folder/said")"

limits=(--max-memory 20000 --max-triangles 100 --quiet)
"$diesink" convert "$folder/sheet.stl" "$folder/sheet.ply" --ascii "${limits[@]}"
large "$folder/sheet.ply"
"$diesink" convert "$folder/sheet.ply" "$folder/back.stl" "${limits[@]}"
# Behind the 80 bytes of text.
cmp --ignore-initial=80 "$folder/sheet.stl" "$folder/back.stl" || fail "the facets differ"
echo "check_large: $(stat -c %s "$folder/sheet.stl") bytes of STL and $(stat -c %s "$folder/sheet.ply") of PLY, the same facets"
