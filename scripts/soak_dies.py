#!/usr/bin/env python3
"""Exports and proves random dies of make_dies.py; tells what fails, takes long or is not certified, and keeps those.

  soak_dies.py aligned|rounded|fine FIRST COUNT [--build build/release] [--folder build/soak] [--slow SECONDS]

Each die is exported by the program (adaptive, every third in tiles), with a limit of 60 s, and proven as a sheet, a
solid and a grid by `tessellation_soak --part`. Ends with 1 where a proof fails, the program crashes or does not end."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

import make_dies

LIMIT = 60  # seconds of one run


def run(*words):
    started = time.monotonic()
    try:
        done = subprocess.run([str(w) for w in words], capture_output=True, text=True, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return None, "", f"does not end in {LIMIT} s", LIMIT
    return done.returncode, done.stdout, done.stderr.strip(), time.monotonic() - started


def look_at(part, seed, options):
    """(failed, lines) of one die."""
    program, proof = options.build / "bin/diesink", options.build / "bin/tessellation_soak"
    failed, lines = False, []
    with tempfile.TemporaryDirectory() as folder:
        tiles = ["--tiles", "2x3"] if seed % 3 == 0 else []
        words = ["export", part, "-o", pathlib.Path(folder) / "die.ply", "--json", "--threads", 1]
        for more in ([], tiles) if tiles else ([],):
            status, out, err, seconds = run(program, *words, *more)
            name = " ".join(["export", *more])
            # Six decimals are not always a plane, and what is drawn may miss the domain.
            if status == 2 and ("not planar" in err or "nothing to tessellate" in err):
                return False, [f"refused: {err.splitlines()[0]}"]
            if status not in (0, 5):
                failed = True
                lines.append(f"{name} ends with {status}: {err[:300]}")
            elif status == 5:
                area = json.loads(out)["uncertified_area"] if not more else err.splitlines()[-1]
                lines.append(f"{name} tells {area} mm2" if not more else f"{name}: {area}")
            if seconds > options.slow and status is not None:
                lines.append(f"{name} takes {seconds:.1f} s")
    status, out, err, _ = run(proof, "--part", part)
    if status != 0:
        failed = True
        lines.append(f"proof ends with {status}: " + (out + err)[:600])
    return failed, lines


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=make_dies.KINDS)
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path("build/release"))
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("build/soak"))
    parser.add_argument("--slow", type=float, default=3, help="seconds from which on a die is told (3)")
    options = parser.parse_args()
    seeds = range(options.first, options.first + options.count)
    told = failures = refused = 0
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as lanes:
        parts = [make_dies.write(options.kind, seed, options.folder) for seed in seeds]
        for seed, part, (failed, lines) in zip(seeds, parts, lanes.map(lambda p, s: look_at(p, s, options), parts, seeds)):
            failures += failed
            refused += any(line.startswith("refused") for line in lines)
            told += any("tells" in line for line in lines)
            for line in lines:
                print(f"{part.name}: {line}", flush=True)
            if not lines:
                part.unlink()
    print(f"{options.count} {options.kind} dies: {failures} failed, {told} tell an area, {refused} refused")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
