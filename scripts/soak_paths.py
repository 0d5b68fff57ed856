#!/usr/bin/env python3
"""Plans tool paths over random dies of make_dies.py with random cutters and ways, checks each with `verify`, and tells
what gouges, what stays untold, what takes long.

  soak_paths.py aligned|rounded|fine FIRST COUNT [--build build/release] [--folder build/soak] [--slow SECONDS]

The seed decides the die, the cutter (flat, ball, bull nose), the method, the angle, zigzag or one-way, the cusp height
and the tolerances. Ends with 1 where a path gouges, plunges at rapid, leaves what it does not tell, or a command
crashes or does not end. Dies that were told of stay in the folder."""
# SPDX-License-Identifier: Apache-2.0
import json
import pathlib
import random
import sys
import tempfile

import make_dies
from soak import LIMIT, Look, options_of, run, soak

CUTTERS = ["6,3", "6,0", "6,1", "10,5", "4,0.8", "3,1.5", "12,2", "8,0"]


def way_of(kind, seed):
    """The options of the path over the die of this seed."""
    rng = random.Random(f"path over {kind} {seed}")
    along = rng.choice(["x", "y", "90", "30", "45", "-60", make_dies.number(rng.uniform(0, 180))])
    tolerance = rng.choice(["0.01", "0.02", "0.05"])
    return ["--cutter", rng.choice(CUTTERS), "--method", rng.choice(["drop", "drop", "cc"]), "--along=" + along,
            "--pattern", rng.choice(["zigzag", "zigzag", "oneway"]), "--cusp", rng.choice(["0.03", "0.05", "0.1", "0.2"]),
            "--intol", tolerance, "--outtol", rng.choice([tolerance, "0.03"])]


def check(part, way, options):
    """(failed, lines) of one die and the path over it."""
    program, threads = options.build / "bin/diesink", ["--threads", 1]
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "path.csv"
        # Meshes are soak_dies.py's subject.
        tolerance = sum(float(way[way.index(key) + 1]) for key in ("--intol", "--outtol")) / 8
        status, _, err, seconds = run(program, "export", part, "-o", pathlib.Path(folder) / "die.ply", "--quiet",
                                      "--tolerance", make_dies.number(tolerance), *threads, limit=LIMIT / 6)
        if status is None:
            return False, [f"passed over: its mesh {err}"]
        status, out, err, seconds = run(program, "cl", part, "-o", path, "--json", *way, *threads)
        if status == 2 and ("lanar" in err or "convex" in err):
            return False, [f"refused: {err.splitlines()[0]}"]  # six decimals are not always a plane
        if status not in (0, 5):
            return True, [f"cl ends with {status}: {err[:300]}"]
        told = json.loads(out)
        lines = [f"cl takes {seconds:.1f} s"] if seconds > options.slow else []
        areas = {key: told[key] for key in ("left_area", "unsettled_area", "uncertified_area") if told[key] > 0}
        too_deep = told["overcut_bound"] > float(way[way.index("--intol") + 1]) * (1 + 1e-9)
        if (status == 5) != (bool(areas) or too_deep):
            return True, [f"cl ends with {status}, though {areas}"]
        if too_deep:
            lines.append(f"cl tells an overcut of {told['overcut_bound']:.5f}")
        if areas:
            lines.append("cl tells " + ", ".join(f"{key} {value:.4g}" for key, value in areas.items()))
        kept = [way[way.index(key) + 1] for key in ("--cutter", "--cusp", "--intol", "--outtol")]
        status, out, err, seconds = run(program, "verify", part, path, "--json", "--cutter", kept[0], "--cusp", kept[1],
                                        "--intol", kept[2], "--outtol", kept[3], *threads)
        if not out:
            return True, lines + [f"verify ends with {status}: {err[:300]}"]
        found = json.loads(out)
        if seconds > options.slow:
            lines.append(f"verify takes {seconds:.1f} s")
        failed = status != 0 or found["rapid_plunges"] > 0
        if failed:
            lines.append(f"verify ends with {status}: gouge {found['max_gouge']:.5f} at {found['max_gouge_at']}, "
                         f"{found['rapid_plunges']} plunges")
        # What was told was counted on another lattice.
        if found["uncut_area"] > 2 * sum(areas.values()):
            failed = True
            lines.append(f"{found['uncut_area']:.4g} mm2 left, told {sum(areas.values()):.4g}, up to "
                         f"{found['max_excess']:.4f} of {found['limit']:.4f} at {found['max_excess_at']}")
    return failed, lines


def look_at(seed, options):
    part, way = make_dies.write(options.kind, seed, options.folder), way_of(options.kind, seed)
    return Look(f"{part.name} {' '.join(way)}", [part], *check(part, way, options))


if __name__ == "__main__":
    sys.exit(soak(look_at, "paths over dies", options_of(__doc__, make_dies.KINDS, slow=10)))
