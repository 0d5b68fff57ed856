#!/usr/bin/env python3
# A die face as a scanner would see it: a mesh with noise, a hole and an overhang, always the same.
# SPDX-License-Identifier: Apache-2.0
"""Writes a binary STL: make_scan.py [--points N] [--seed S] [--noise MM] [--shuffle] OUT.stl

A relief of 80 x 60 mm with a raised boss whose rim hangs over, random noise along z, and one hole
of about 7 mm. N is the number of points along x (default 97). --plain leaves out hole and overhang.
"""
import argparse
import math
import random
import struct
import sys

WIDTH, HEIGHT = 80.0, 60.0


def height(x, y):
    z = 3.0 * math.sin(x / 14) * math.cos(y / 11) + 0.02 * (x - 40)
    r = math.hypot(x - 52, y - 34)
    return z + 6.0 / (1.0 + math.exp((r - 12) / 0.9))


def lean(x, y):
    """How far the boss's flank is pushed outwards at its upper edge: an overhang."""
    r = math.hypot(x - 52, y - 34)
    return 3.5 * math.exp(-((r - 10.5) / 1.3) ** 2)


def make(points, seed, noise, plain):
    rng = random.Random(seed)
    nx, ny = points, max(2, round(points * HEIGHT / WIDTH))
    vertices = []
    for j in range(ny):
        for i in range(nx):
            x, y = WIDTH * i / (nx - 1), HEIGHT * j / (ny - 1)
            inner = 0 < i < nx - 1 and 0 < j < ny - 1
            dx, dy = (rng.uniform(-0.2, 0.2) * WIDTH / (nx - 1) for _ in range(2))
            z = height(x, y) + rng.gauss(0, noise)
            if inner:
                x, y = x + dx, y + dy
            if inner and not plain:
                r = math.hypot(x - 52, y - 34)
                if r > 0:
                    push = lean(x, y)
                    x, y = x + push * (x - 52) / r, y + push * (y - 34) / r
            vertices.append((x, y, z))
    triangles = []
    for j in range(ny - 1):
        for i in range(nx - 1):
            x, y = WIDTH * (i + 0.5) / (nx - 1), HEIGHT * (j + 0.5) / (ny - 1)
            if not plain and math.hypot((x - 18) / 1.2, y - 20) < 3.3:
                continue
            a, b, c, d = j * nx + i, j * nx + i + 1, (j + 1) * nx + i + 1, (j + 1) * nx + i
            if (i + j) % 2:
                triangles += [(a, b, c), (a, c, d)]
            else:
                triangles += [(a, b, d), (b, c, d)]
    return vertices, triangles


def main():
    parser = argparse.ArgumentParser(description="a die face as a scanner would see it")
    parser.add_argument("--points", type=int, default=97, help="points along x")
    parser.add_argument("--seed", type=int, default=1988)
    parser.add_argument("--noise", type=float, default=0.02, help="standard deviation along z, mm")
    parser.add_argument("--plain", action="store_true", help="no hole and no overhang")
    parser.add_argument("--shuffle", action="store_true", help="triangles in random order")
    parser.add_argument("output")
    args = parser.parse_args()
    vertices, triangles = make(args.points, args.seed, args.noise, args.plain)
    if args.shuffle:
        random.Random(args.seed).shuffle(triangles)
    # As floats, as the file holds them.
    vertices = [struct.unpack("<3f", struct.pack("<3f", *v)) for v in vertices]
    out = bytearray(b"diesink scan of a die face, mm".ljust(80))
    out += struct.pack("<I", len(triangles))
    for t in triangles:
        out += struct.pack("<12f", 0, 0, 0, *(x for k in t for x in vertices[k])) + b"\0\0"
    with open(args.output, "wb") as file:
        file.write(out)
    return 0


if __name__ == "__main__":
    sys.exit(main())
