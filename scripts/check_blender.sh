#!/usr/bin/env bash
# Blender, without its window, reads the STL, OBJ and PLY that diesink writes: same triangles, bounds and closed edges.
# usage: scripts/check_blender.sh [PART]        default: fixtures/parts/fig6.part; needs build/release/bin/diesink
# Blender 3.3 and later. Where there is none the script says so and ends with 0.
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."

if ! command -v blender >/dev/null; then
  echo "check_blender: skipped, there is no blender here (Debian package blender)"
  exit 0
fi
diesink=$PWD/build/release/bin/diesink
[ -x "$diesink" ] || { echo "check_blender: $diesink is missing; build it first" >&2; exit 1; }
part=${1:-fixtures/parts/fig6.part}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

"$diesink" export "$part" --solid --tolerance 0.05 --quiet \
  -o "$scratch/a.stl" -o "$scratch/a.obj" -o "$scratch/a.ply"
for file in "$scratch"/a.{stl,obj,ply}; do
  "$diesink" info "$file" --json >"$file.json"
done

cat >"$scratch/read.py" <<'PYTHON'
import json
import sys

import bmesh
import bpy


def first_of(*ways):
    """The first importer this Blender has; which they are changed with 3.3 and 4.0."""
    for group, name, options in ways:
        if name in dir(getattr(bpy.ops, group)):
            return lambda path: getattr(getattr(bpy.ops, group), name)(filepath=path, **options)
    raise SystemExit("no importer for this format")


IMPORT = {
    "stl": first_of(("wm", "stl_import", {}), ("import_mesh", "stl", {})),
    "ply": first_of(("wm", "ply_import", {}), ("import_mesh", "ply", {})),
    "obj": first_of(("wm", "obj_import", {"forward_axis": "Y", "up_axis": "Z"}),
                    ("import_scene", "obj", {"axis_forward": "Y", "axis_up": "Z"})),
}
failed = False
for path in sys.argv[sys.argv.index("--") + 1:]:
    kind = path.rsplit(".", 1)[1]
    with open(path + ".json", encoding="utf-8") as told:
        expected = json.load(told)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    IMPORT[kind](path)
    whole = bmesh.new()
    for each in bpy.data.objects:
        if each.type == "MESH":
            each.data.transform(each.matrix_world)
            whole.from_mesh(each.data)
    # Objects of one file, and an STL's facets, meet in equal positions.
    bmesh.ops.remove_doubles(whole, verts=whole.verts, dist=0)
    low = [min(v.co[i] for v in whole.verts) for i in range(3)]
    high = [max(v.co[i] for v in whole.verts) for i in range(3)]
    size = max(b - a for a, b in zip(*expected["bounds"]))
    off = max(abs(a - b) for a, b in zip(low + high, sum(expected["bounds"], [])))
    closed = all(len(edge.link_faces) == 2 for edge in whole.edges)
    same = len(whole.faces) == expected["triangles"] and off <= 1e-6 * size and closed == expected["watertight"]
    print(f"check_blender: {kind}: {len(whole.faces)} of {expected['triangles']} triangles, bounds off by {off:.3g}, "
          f"closed {closed} of {expected['watertight']}: {'same' if same else 'DIFFERENT'}")
    failed = failed or not same
    whole.free()
if failed:
    raise SystemExit(1)
PYTHON
blender --background --factory-startup --python-exit-code 1 --python "$scratch/read.py" -- "$scratch"/a.{stl,obj,ply} |
  grep '^check_blender:'
