#!/usr/bin/env python3
"""Times whole commands, start to end with reading and writing, the fastest of several runs each.

Two figures: the processor's seconds on one thread, which hardly depend on what else the machine does, and the seconds on
the clock with all cores.
usage: time_commands.py [--program PROGRAM] [--runs N] [--page FILE]    (default build/release/bin/diesink, 3)
  --page   put the table into a page as well, between <!-- commands --> and <!-- end -->: docs/benchmarks.md
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import pathlib
import subprocess
import tempfile
import time

import page_table

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIG6 = ROOT / "fixtures/parts/fig6.part"
LID = ROOT / "docs/examples/lid.part"
COMMANDS = [
    ("`fig6.part` to STL at its tolerance, 0.02", ["export", FIG6, "-o", "a.stl"]),
    ("the same at 0.001", ["export", FIG6, "--tolerance", "0.001", "-o", "a.stl"]),
    ("the same at 0.02 to GLB with Draco", ["export", FIG6, "--draco", "-o", "a.glb"]),
    ("50 pockets and 50 bosses (`pockets.part`) to STL at 0.01", ["export", ROOT / "fixtures/parts/pockets.part", "-o", "a.stl"]),
    ("CC-data of the grid of `fig6.part`", ["cc", FIG6, "-o", "a.csv"]),
    ("picture of it, 1600 x 1200", ["preview", FIG6, "--size", "1600x1200", "-o", "a.png"]),
    ("tool path over it, ball of 6, cusps of 0.01", ["cl", FIG6, "--cutter", "6,3", "--cusp", "0.01", "-o", "a.apt"]),
    ("the check of that path over its whole swept volume", ["verify", FIG6, "a.apt", "--cusp", "0.01"]),
    ("tool path over the README's lid, 90 x 60, ball of 6, cusps of 0.02", ["cl", LID, "-o", "lid.ngc"]),
    ("its check", ["verify", LID, "lid.ngc"]),
]


def run(words, folder):
    """Seconds of the processor, and on the clock."""
    begun = time.perf_counter()
    with subprocess.Popen([*map(str, words), "--quiet"], cwd=folder, stderr=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"time_commands: {' '.join(map(str, words))} ends with {process.returncode}")
    return used.ru_utime + used.ru_stime, time.perf_counter() - begun


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default="build/release/bin/diesink")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--page", type=pathlib.Path)
    options = parser.parse_args()
    program = options.program.resolve()
    rows = [("what", "processor, one thread, s", f"clock, {os.cpu_count()} cores, s")]
    with tempfile.TemporaryDirectory() as folder:
        for what, words in COMMANDS:
            one = min(run([program, *words, "--threads", "1"], folder)[0] for _ in range(options.runs))
            clock = min(run([program, *words], folder)[1] for _ in range(options.runs))
            rows.append((what, f"{one:.3f}", f"{clock:.3f}"))
            print(f"{what:<62} {one:8.3f} s {clock:8.3f} s", flush=True)
    if options.page:
        about = f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.2f}, {time.strftime('%Y-%m-%d')}\n\n"
        page_table.replace(options.page, "commands", about + page_table.markdown(rows))


if __name__ == "__main__":
    main()
