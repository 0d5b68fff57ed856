#!/usr/bin/env python3
"""Times whole commands on one thread, start to end with reading and writing: the processor's seconds of the fastest run.

Unlike the time on the clock they hardly depend on what else the machine does.
usage: time_commands.py [--program PROGRAM] [--runs N]    (default build/release/bin/diesink, 3)
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import os
import pathlib
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIG6 = ROOT / "fixtures/parts/fig6.part"
LID = ROOT / "docs/examples/lid.part"
COMMANDS = [
    ("fig6 to STL at 0.02", ["export", FIG6, "-o", "a.stl"]),
    ("fig6 to STL at 0.001", ["export", FIG6, "--tolerance", "0.001", "-o", "a.stl"]),
    ("fig6 to GLB with Draco", ["export", FIG6, "--draco", "-o", "a.glb"]),
    ("50 pockets and 50 bosses to STL at 0.01", ["export", ROOT / "fixtures/parts/pockets.part", "-o", "a.stl"]),
    ("fig6, CC-data of the grid", ["cc", FIG6, "-o", "a.csv"]),
    ("fig6, picture of 1600 x 1200", ["preview", FIG6, "--size", "1600x1200", "-o", "a.png"]),
    ("fig6, tool path, ball of 6, cusps of 0.01", ["cl", FIG6, "--cutter", "6,3", "--cusp", "0.01", "-o", "a.apt"]),
    ("its check", ["verify", FIG6, "a.apt", "--cusp", "0.01"]),
    ("lid, tool path, ball of 6, cusps of 0.02", ["cl", LID, "-o", "lid.ngc"]),
    ("its check", ["verify", LID, "lid.ngc"]),
]


def processor_seconds(words, folder):
    with subprocess.Popen([*map(str, words), "--threads", "1", "--quiet"], cwd=folder, stderr=subprocess.DEVNULL) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"time_commands: {' '.join(map(str, words))} ends with {process.returncode}")
    return used.ru_utime + used.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default="build/release/bin/diesink")
    parser.add_argument("--runs", type=int, default=3)
    options = parser.parse_args()
    program = options.program.resolve()
    with tempfile.TemporaryDirectory() as folder:
        for what, words in COMMANDS:
            seconds = min(processor_seconds([program, *words], folder) for _ in range(options.runs))
            print(f"{what:<42} {seconds:8.3f} s", flush=True)


if __name__ == "__main__":
    main()
