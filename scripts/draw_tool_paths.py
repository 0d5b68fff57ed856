#!/usr/bin/env python3
"""Draws Fig. 13 of the paper: CC-paths with normals, CL-paths with loops, CL-paths without interference.
usage: scripts/draw_tool_paths.py PROGRAM PART OUT.svg"""
# SPDX-License-Identifier: Apache-2.0
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

WIDTH, GAP = 520, 20


def project(p):
    """A parallel view from the front left, 30 degrees up."""
    turn, up = math.radians(-30), math.radians(32)
    x = p[0] * math.cos(turn) - p[1] * math.sin(turn)
    y = p[0] * math.sin(turn) + p[1] * math.cos(turn)
    return x, y * math.sin(up) + p[2] * math.cos(up)


def cc_lines(path):
    passes, normals = {}, []
    with open(path) as file:
        for row in csv.DictReader(file):
            p = [float(row[k]) for k in "xyz"]
            n = [float(row[k]) for k in ("nx", "ny", "nz")]
            passes.setdefault(row["pass"], []).append(p)
            normals.append([p, [a + 1.5 * b for a, b in zip(p, n)]])
    return list(passes.values()), normals[::2]


def cl_lines(path, clearance):
    """Cutting moves below the clearance plane, split at rapid moves."""
    lines, current = [], []
    for line in open(path):
        if line[0] in "#x":
            continue
        x, y, z, motion = line.strip().split(",")
        p = [float(x), float(y), float(z)]
        if motion == "rapid" or p[2] > clearance:
            lines.append(current)
            current = []
        if motion == "feed" and p[2] <= clearance:
            current.append(p)
    return [line for line in lines + [current] if len(line) > 1]


def main():
    program, part, out = sys.argv[1:4]
    folder = pathlib.Path(tempfile.mkdtemp())
    common = [program, "cl", part, "--method", "cc", "--cutter", "6,3", "--interval", "2.5", "--intol", "0.05",
              "--outtol", "0.05", "--pattern", "oneway", "--quiet"]
    subprocess.run([*common, "-o", folder / "clean.csv", "--cc", folder / "cc.csv"], check=True)
    subprocess.run([*common, "-o", folder / "raw.csv", "--keep-interference"], check=True)
    passes, normals = cc_lines(folder / "cc.csv")
    top = max(p[2] for line in passes for p in line) + 1
    panels = [("CC-paths with normals", [(passes, "#1b3a57", 0.9), (normals, "#c0392b", 0.4)]),
              ("CL-paths by equation (6), with loops", [(cl_lines(folder / "raw.csv", top), "#1b3a57", 0.9)]),
              ("CL-paths, interferences removed", [(cl_lines(folder / "clean.csv", top), "#1b3a57", 0.9)])]
    points = [project(p) for line in passes for p in line]
    x0, x1 = min(p[0] for p in points), max(p[0] for p in points)
    y0, y1 = min(p[1] for p in points), max(p[1] for p in points)
    scale = (WIDTH - 2 * GAP) / (x1 - x0)
    height = round((y1 - y0) * scale + 4 * GAP)
    svg = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{3 * height}" '
           f'viewBox="0 0 {WIDTH} {3 * height}" font-family="sans-serif" font-size="14">',
           f'<rect width="{WIDTH}" height="{3 * height}" fill="white"/>']
    for k, (title, layers) in enumerate(panels):
        svg.append(f'<text x="{GAP}" y="{k * height + 20}">{title}</text>')
        for lines, color, width in layers:
            data = "".join("M" + "L".join(f"{GAP + (x - x0) * scale:.1f},{(k + 1) * height - GAP - (y - y0) * scale:.1f}"
                                          for x, y in map(project, line)) for line in lines)
            svg.append(f'<path d="{data}" fill="none" stroke="{color}" stroke-width="{width}"/>')
    pathlib.Path(out).write_text("\n".join(svg + ["</svg>\n"]))


if __name__ == "__main__":
    main()
