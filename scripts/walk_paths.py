#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Plans and checks tool paths for part programs, over cutters, methods and directions.

    scripts/walk_paths.py build/release/bin/diesink fixtures/parts/*.part [--cusp 0.1] [--quick]

Every path is written as APT of the four flavours, as G-code and as CSV; all six must hold the same
path to the check. Fails where a path gouges, plunges at rapid, or leaves more than it tells."""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

CUTTERS = ["6,3", "6,1", "6,0"]
WAYS = [("drop", "x"), ("drop", "y"), ("drop", "30"), ("cc", "x"), ("cc", "30"), ("cc", "u"),
        ("cc", "v")]
FLAVOURS = ["apt", "nx", "catia", "creo"]


def run(*words):
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr.strip()


def check(program, part, path, cutter, cusp, *more):
    status, out, err = run(program, "verify", part, path, "--cutter", cutter, "--cusp", cusp,
                           "--json", *more)
    return status, json.loads(out) if out else None, err


def walk(program, part, cutter, method, along, cusp, folder, quick):
    """The complaints about one path, and what was found."""
    words = ["cl", part, "--cutter", cutter, "--cusp", cusp, "--method", method, "--along", along]
    files = [folder / f"path{ending}" for ending in (".apt", ".ngc", ".csv")]
    status, out, err = run(program, *words, "--json", *[w for f in files for w in ("-o", f)])
    if status not in (0, 5):
        fitting = along in "uv" and status == 3
        return [] if fitting else [f"cl ends with {status}: {err}"], f"refused: {err}"
    told = json.loads(out)
    complaints = []
    if (status == 5) != (told["left_area"] > 0 or told["uncertified_area"] > 0):
        complaints.append(f"cl ends with {status}, left {told['left_area']}")
    status, found, err = check(program, part, files[2], cutter, cusp)
    if found is None:
        return complaints + [f"verify ends with {status}: {err}"], ""
    if status != 0 or found["rapid_plunges"]:
        complaints.append(f"verify ends with {status}, gouge {found['max_gouge']}")
    # What was told was counted on another lattice.
    if found["uncut_area"] > 2 * told["left_area"] + 1e-6:
        complaints.append(f"{found['uncut_area']:.3g} left, told {told['left_area']:.3g}, "
                          f"up to {found['max_excess']:.3g} at {found['max_excess_at']}")
    if not quick:
        for flavour in FLAVOURS[1:]:
            files.append(folder / f"path.{flavour}.apt")
            run(program, *words, "--flavour", flavour, "-o", files[-1])
        coarse = ["--spacing", "1"]
        length = check(program, part, files[2], cutter, cusp, *coarse)[1]["length"]
        for file in files:
            other = check(program, part, file, cutter, cusp, *coarse)
            if other[1] is None or abs(other[1]["length"] - length) > 1e-4 * length:
                complaints.append(f"{file.name} is not the same path: {other[2]}")
    return complaints, (f"gouge {found['max_gouge']:.4f} excess {found['max_excess']:.4f} of "
                        f"{found['limit']:.4f} left {found['uncut_area']:.4f} "
                        f"cutting {told['feed_length']:.0f} rapid {told['rapid_length']:.0f}")


def main():
    words = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    words.add_argument("program", type=pathlib.Path)
    words.add_argument("parts", type=pathlib.Path, nargs="+")
    words.add_argument("--cusp", default="0.1")
    words.add_argument("--quick", action="store_true", help="only the CSV is checked")
    words = words.parse_args()
    bad = 0
    with tempfile.TemporaryDirectory() as folder:
        for part in words.parts:
            for cutter in CUTTERS:
                for method, along in WAYS:
                    complaints, found = walk(words.program, part, cutter, method, along, words.cusp,
                                             pathlib.Path(folder), words.quick)
                    print(f"{part.stem} {cutter} {method} {along}: {found}", flush=True)
                    for complaint in complaints:
                        bad += 1
                        print(f"  BAD {complaint}", flush=True)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
