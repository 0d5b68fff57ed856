#!/usr/bin/env python3
"""Writes random small scans (binary STL) and part programs with solids over them.

  make_scans.py KIND FIRST COUNT FOLDER   KIND: relief, holes, overhang, closed, terraces, repeated, flush, cracked,
                                          layered, slivers, or all (one of each in turn)

Each seed of FIRST..FIRST+COUNT-1 makes FOLDER/KIND<seed>.stl and .part; the same seed gives the same bytes."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import math
import pathlib
import random
import struct

from make_dies import statement

SIDE = 60.0


def as_float(value):
    return struct.unpack("<f", struct.pack("<f", value))[0]


def lattice(rng, nx, ny, height, shake=0.0):
    """Vertices over the square and two triangles a cell, the diagonals any way."""
    vertices, triangles = [], []
    for j in range(ny):
        for i in range(nx):
            x, y = SIDE * i / (nx - 1), SIDE * j / (ny - 1)
            z = height(x, y)
            if 0 < i < nx - 1 and 0 < j < ny - 1:
                x += rng.uniform(-shake, shake) * SIDE / (nx - 1)
                y += rng.uniform(-shake, shake) * SIDE / (ny - 1)
            vertices.append((x, y, z))
    for j in range(ny - 1):
        for i in range(nx - 1):
            a, b, c, d = j * nx + i, j * nx + i + 1, (j + 1) * nx + i + 1, (j + 1) * nx + i
            triangles += [(a, b, c), (a, c, d)] if rng.random() < 0.5 else [(a, b, d), (b, c, d)]
    return vertices, triangles


def hills(rng, noise):
    a, b, c = rng.uniform(4, 15), rng.uniform(4, 15), rng.uniform(0, 4)
    return lambda x, y: c * math.sin(x / a) * math.cos(y / b) + rng.gauss(0, noise)


def relief(rng):
    n = rng.randint(8, 48)
    return lattice(rng, n, rng.randint(8, 48), hills(rng, rng.choice([0, 0.01, 0.05, 0.3])), rng.choice([0, 0.2, 0.35]))


def holes(rng):
    vertices, triangles = relief(rng)
    spots = [(rng.uniform(0, SIDE), rng.uniform(0, SIDE), rng.choice([1, 3, 8])) for _ in range(rng.randint(1, 5))]
    lost = rng.choice([0, 0, 0.02, 0.2])

    def stays(t):
        x, y = (sum(vertices[v][k] for v in t) / 3 for k in (0, 1))
        return rng.random() >= lost and all(math.hypot(x - a, y - b) > r for a, b, r in spots)
    return vertices, [t for t in triangles if stays(t)]


def overhang(rng):
    n = rng.randint(24, 56)
    knobs = [(rng.uniform(10, 50), rng.uniform(10, 50), rng.uniform(4, 12), rng.uniform(2, 8), rng.uniform(1, 4))
             for _ in range(rng.randint(1, 3))]
    base = hills(rng, rng.choice([0, 0.02]))

    def height(x, y):
        return base(x, y) + sum(h / (1 + math.exp((math.hypot(x - a, y - b) - r) / 0.6)) for a, b, r, h, _ in knobs)
    vertices, triangles = lattice(rng, n, n, height, 0.2)
    moved = []
    for x, y, z in vertices:
        if 0 < x < SIDE and 0 < y < SIDE:
            for a, b, r, _, lean in knobs:
                d = math.hypot(x - a, y - b)
                if d > 0:
                    push = lean * math.exp(-((d - r + 1) / 1.3) ** 2)
                    x, y = x + push * (x - a) / d, y + push * (y - b) / d
        moved.append((x, y, z))
    return moved, triangles


def ball(rng, centre, radii, rings, noise=0.0):
    around = 2 * rings
    vertices = []
    for j in range(rings + 1):
        for i in range(around):
            t, p = math.pi * j / rings, 2 * math.pi * i / around
            f = 1 + (rng.gauss(0, noise) if 0 < j < rings else 0)  # at a pole all are one
            vertices.append(tuple(c + f * r * u for c, r, u in zip(
                centre, radii, (math.sin(t) * math.cos(p) * (0 < j < rings), math.sin(t) * math.sin(p) * (0 < j < rings), math.cos(t)))))
    triangles = []
    for j in range(rings):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            if j > 0:
                triangles.append((a, a + around, b))
            if j + 1 < rings:
                triangles.append((b, a + around, b + around))
    return vertices, triangles


def block(low, high):
    vertices = [tuple((low, high)[k >> axis & 1][axis] for axis in range(3)) for k in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return vertices, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def drum(centre, radius, height, sides, turn):
    x, y, z = centre
    vertices = [(x, y, z), (x, y, z + height)]
    for level in (z, z + height):
        for k in range(sides):
            a = turn + 2 * math.pi * k / sides
            vertices.append((x + radius * math.cos(a), y + radius * math.sin(a), level))
    triangles = []
    for k in range(sides):
        a, b = 2 + k, 2 + (k + 1) % sides
        triangles += [(0, b, a), (1, a + sides, b + sides), (a, b, b + sides), (a, b + sides, a + sides)]
    return vertices, triangles


def together(pieces):
    vertices, triangles = [], []
    for v, t in pieces:
        triangles += [tuple(k + len(vertices) for k in corner) for corner in t]
        vertices += v
    return vertices, triangles


def closed(rng):
    pieces = []
    for _ in range(rng.randint(1, 5)):
        x, y, z = rng.uniform(8, 52), rng.uniform(8, 52), rng.uniform(-3, 3)
        r = rng.uniform(4, 22)
        kind = rng.randrange(3)
        if kind == 0:
            pieces.append(ball(rng, (x, y, z), (r, r * rng.choice([1, 0.6]), r * rng.choice([1, 0.4])), rng.randint(4, 16),
                               rng.choice([0, 0, 0.01, 0.05])))
        elif kind == 1:
            pieces.append(block((x - r, y - r, z - 3), (x + r, y + r * rng.uniform(0.2, 1), z + rng.uniform(1, 8))))
        else:
            pieces.append(drum((x, y, z - 2), r, rng.uniform(1, 9), rng.choice([3, 4, 6, 12, 40]), rng.choice([0, rng.uniform(0, 1)])))
    return together(pieces)


def terraces(rng):
    """Steps of round heights with upright walls on round lines, as of a drawing."""
    step = rng.choice([3.0, 5.0, 6.0, 10.0])
    n = int(SIDE / step)
    level = [[rng.choice([0, 0, 1, 2, 2.5]) for _ in range(n)] for _ in range(n)]
    vertices, triangles, numbers = [], [], {}

    def at(*p):
        if p not in numbers:
            numbers[p] = len(vertices)
            vertices.append(p)
        return numbers[p]

    def quad(*corners):
        a, b, c, d = (at(*p) for p in corners)
        triangles.extend([(a, b, c), (a, c, d)] if rng.random() < 0.5 else [(a, b, d), (b, c, d)])
    for j in range(n):
        for i in range(n):
            x0, x1, y0, y1, z = i * step, (i + 1) * step, j * step, (j + 1) * step, level[j][i]
            quad((x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z))
            if i + 1 < n and level[j][i + 1] != z:
                quad((x1, y0, z), (x1, y0, level[j][i + 1]), (x1, y1, level[j][i + 1]), (x1, y1, z))
            if j + 1 < n and level[j + 1][i] != z:
                quad((x0, y1, z), (x1, y1, z), (x1, y1, level[j + 1][i]), (x0, y1, level[j + 1][i]))
    return vertices, triangles


def repeated(rng):
    """Triangles twice, turned over, without area, and edges that end on others."""
    vertices, triangles = rng.choice([relief, overhang, terraces])(rng)
    for t in list(triangles):
        chance = rng.random()
        if chance < 0.03:
            triangles.append(t)
        elif chance < 0.06:
            triangles.append((t[1], t[0], t[2]))
        elif chance < 0.08:
            triangles.append((t[0], t[1], t[1]))
        elif chance < 0.10:
            middle = tuple((p + q) / 2 for p, q in zip(vertices[t[0]], vertices[t[1]]))
            vertices.append(middle)
            triangles += [(t[0], len(vertices) - 1, t[2]), (len(vertices) - 1, t[1], t[2])]
            triangles.remove(t)
        elif chance < 0.11:
            vertices.extend(tuple(c + (k == 2) * 0.001 for k, c in enumerate(vertices[v])) for v in t)
            triangles.append((len(vertices) - 3, len(vertices) - 2, len(vertices) - 1))
    return vertices, triangles


def flush(rng):
    """Plates of round heights and slopes, for solids that end in them."""
    n = rng.choice([4, 7, 13])
    slope = rng.choice([0, 0, 1, 2])
    ridge = rng.choice([20, 30])

    def height(x, y):
        return {0: 0, 1: max(0, x - ridge) / 2, 2: max(0, min(x, y) - ridge)}[slope]
    return lattice(rng, n, n, height)


def cracked(rng):
    """No two facets share their vertices to the bit: gaps and overlaps of some rounding."""
    vertices, triangles = rng.choice([relief, overhang])(rng)
    off = rng.choice([1e-6, 1e-5, 1e-3])
    out, corners = [], []
    for t in triangles:
        corners.append(tuple(range(len(out), len(out) + 3)))
        out += [tuple(c + rng.uniform(-off, off) for c in vertices[v]) for v in t]
    return out, corners


def layered(rng):
    """Two scans of one thing, nearly on one another, the second over a part."""
    vertices, triangles = relief(rng)
    lift, turn = rng.choice([0, 0.003, 0.05, 1]), rng.choice([0, 0.001, 0.02])
    low, high = rng.uniform(0, 25), rng.uniform(35, 60)
    part = [t for t in triangles if all(low <= vertices[v][0] <= high for v in t)]
    second = [(x * math.cos(turn) - y * math.sin(turn) + rng.choice([0, 0.01]), x * math.sin(turn) + y * math.cos(turn),
               z + lift + rng.gauss(0, lift / 3)) for x, y, z in vertices]
    return together([(vertices, triangles), (second, part)])


def slivers(rng):
    """Rows far closer one way than the other, and needles up and down."""
    nx = rng.choice([60, 150])
    vertices, triangles = lattice(rng, nx, rng.randint(3, 8), hills(rng, 0.02), rng.choice([0, 0.45]))
    for _ in range(rng.randint(0, 12)):
        k = rng.randrange(len(vertices))
        x, y, z = vertices[k]
        vertices[k] = (x, y, z + rng.choice([-1, 1]) * rng.uniform(1, 10))
    return vertices, triangles


KINDS = {"relief": relief, "holes": holes, "overhang": overhang, "closed": closed, "terraces": terraces, "repeated": repeated,
         "flush": flush, "cracked": cracked, "layered": layered, "slivers": slivers}


def placements(rng, kind):
    """Statements of the placement; mostly one that leaves the scan over its square, more or less."""
    chance = rng.random()
    if chance < 0.5:
        return []
    if chance < 0.65:
        return [("MOVE", -SIDE / 2, -SIDE / 2, 0), ("ROTZ", rng.choice([90, 180, rng.uniform(0, 90)])), ("MOVE", SIDE / 2, SIDE / 2, 0)]
    if chance < 0.75:
        return [("SCALE", rng.choice([0.5, 1.5, 25.4]))]
    if chance < 0.85:
        return [("MOVE", 0, -SIDE / 2, 0), ("ROTX", rng.choice([180, 4, rng.uniform(-8, 8)])), ("MOVE", 0, SIDE / 2, 0)]
    if chance < 0.92:
        return [("MOVE", -SIDE / 2, 0, 0), ("ROTY", rng.choice([180, rng.uniform(-20, 20)] + [90] * (kind == "closed"))), ("MOVE", SIDE / 2, 0, 0)]
    return [("MOVE", rng.uniform(-5, 5), rng.choice([1e3, 1e5]), 0)]


def placed(points, statements):
    for keyword, *v in statements:
        if keyword == "SCALE":
            points = [tuple(c * v[0] for c in p) for p in points]
        elif keyword == "MOVE":
            points = [tuple(c + d for c, d in zip(p, v)) for p in points]
        else:
            axis = "XYZ".index(keyword[3])
            a = math.radians(v[0])
            i, j = (axis + 1) % 3, (axis + 2) % 3
            turned = []
            for p in points:
                q = list(p)
                q[i], q[j] = p[i] * math.cos(a) - p[j] * math.sin(a), p[i] * math.sin(a) + p[j] * math.cos(a)
                turned.append(tuple(q))
            points = turned
    return points


def solids(rng, kind, low, high):
    """Some solids over a box: (sign, type, numbers...), numbers as the program has them."""
    size = [b - a for a, b in zip(low, high)]
    wide = max(size[:2])
    even = kind in ("flush", "terraces") and rng.random() < 0.7 and wide < 3 * SIDE

    def at(axis):
        if even:
            return low[axis] + round(rng.uniform(0, size[axis])) if axis < 2 else rng.choice([0, 0, 1, 2, 2.5])
        return rng.uniform(low[axis], high[axis])

    def far(share):
        r = wide * share * rng.choice([0.1, 0.5, 1])
        return max(1, round(r)) if even else r
    made = []
    for _ in range(rng.randint(0 if rng.random() < 0.2 else 1, 5)):
        x, y, z = at(0), at(1), at(2)
        r, h = far(0.2), far(0.12)
        shape = rng.randrange(5)
        if shape == 0:
            body = ("SPHER", (x, y, z), r)
        elif shape == 1:
            body = ("BLOCK", (x, y, z - rng.choice([0, h])), (x + r, y + far(0.3), z + h))
        elif shape == 2:
            body = ("R-CYLI", (x, y, z - h), (x, y, z + h), r)
        elif shape == 3:
            body = ("R-CYLI", (x, y, z), (x + far(0.4), y + rng.choice([0, far(0.3)]), z + rng.choice([0, far(0.05)])), h)
        else:
            body = ("R-CONE", (x, y, z - h), (x, y, z + rng.choice([1, 2]) * h), r)
        rounded = tuple(tuple(round(c, 6) + 0.0 for c in part) if isinstance(part, tuple) else
                        part if isinstance(part, str) else round(part, 6) for part in body)
        made.append((rng.choice("++-"), *rounded))
    return made


def program(name, kind, seed, statements, bodies, domain, tolerance, fill):
    lines = [f"$$ {kind} {seed}", "SOLID-DEF"]
    for k, (_, shape, *data) in enumerate(bodies):
        head = f"S{k + 1},"
        if shape == "SPHER":
            lines += [head + "SPHER", statement("P1", *data[0]), statement("RAD", data[1])]
        elif shape == "BLOCK":
            lines += [head + "4-PRIS,3", statement("P1", *data[0]), statement("P2", *data[1])]
        else:
            lines += [head + shape, statement("P1", *data[0]), statement("P2", *data[1]), statement("RAD", data[2])]
    lines += ["BSURF-DEF", f"MESH,{name}"] + [statement(*s) for s in statements]
    if fill:
        lines.append(statement("FILL", fill))
    lines += ["BOOLE-DEF", "B" + "".join(f"{sign}S{k + 1}" for k, (sign, *_) in enumerate(bodies)), "MACHI-DEF",
              statement("TOLER", tolerance)]
    if domain:
        lines += [statement("X-RNG", *domain[:2]), statement("Y-RNG", *domain[2:])]
    return "\n".join(lines) + "\n"


def make(kind, seed):
    """(vertices as the file holds them, triangles, statements, bodies, domain or None, tolerance, size to fill)."""
    rng = random.Random(f"{kind} {seed}")
    vertices, triangles = KINDS[kind](rng)
    vertices = [tuple(as_float(c) for c in p) for p in vertices]
    statements = [(keyword, *(round(v, 6) + 0.0 for v in values)) for keyword, *values in placements(rng, kind)]
    points = placed([vertices[v] for t in triangles for v in t], statements)
    low, high = ([pick(p[axis] for p in points) for axis in range(3)] for pick in (min, max))
    bodies = solids(rng, kind, low, high)
    chance = rng.random()
    x0, x1, y0, y1 = low[0], high[0], low[1], high[1]
    w, h = x1 - x0, y1 - y0
    domain = None
    if chance < 0.3:
        domain = (x0 + 0.1 * w, x1 - 0.2 * w, y0 + 0.3 * h, y1)
    elif chance < 0.4:
        domain = (x0 - 0.1 * w, x1, y0, y1 + 0.2 * h)
    elif chance < 0.7 and not statements:
        domain = (0, SIDE, 0, SIDE) if chance < 0.6 else (10, 50, 5, 40)
    domain = domain and tuple(round(v, 6) for v in domain)
    tolerance = rng.choice([0.01, 0.02, 0.05, 0.2]) * max(1, w / SIDE)
    fill = rng.choice([2, 8]) if kind in ("holes", "overhang") and rng.random() < 0.4 else 0
    return vertices, triangles, statements, bodies, domain, round(tolerance, 6), fill


def write(kind, seed, folder):
    """The path of the part program; the scan stands beside it."""
    folder.mkdir(parents=True, exist_ok=True)
    vertices, triangles, *rest = make(kind, seed)
    path = folder / f"{kind}{seed}.part"
    scan = path.with_suffix(".stl")
    out = bytearray(b"diesink scan".ljust(80)) + struct.pack("<I", len(triangles))
    for t in triangles:
        out += struct.pack("<12f", 0, 0, 0, *(c for v in t for c in vertices[v])) + b"\0\0"
    scan.write_bytes(out)
    path.write_text(program(scan.name, kind, seed, *rest))
    return path


def kind_of(kind, seed):
    return list(KINDS)[seed % len(KINDS)] if kind == "all" else kind


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=[*KINDS, "all"])
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("folder", type=pathlib.Path)
    options = parser.parse_args()
    for seed in range(options.first, options.first + options.count):
        write(kind_of(options.kind, seed), seed, options.folder)


if __name__ == "__main__":
    main()
