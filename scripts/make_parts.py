#!/usr/bin/env python3
"""Writes part programs that are too long to write by hand. The same arguments give the same text.

  make_parts.py pockets           50 sphere pockets and 50 bosses on a plate (fixtures/parts/pockets.part)
  make_parts.py pockets --radii F the same with all radii F times as large, F up to 1
  make_parts.py solids N          N solids of every type on a Ferguson base; 400 of them on 1000 x 1000, other
                                  numbers at the same density
  make_parts.py solids N --warp   the same on a base whose points are not on a regular plan grid
"""
# SPDX-License-Identifier: Apache-2.0
import argparse
import math
import random
import sys


def number(value):
    return repr(round(value, 4) + 0.0)


def statement(keyword, *values):
    return ",".join([keyword] + [v if isinstance(v, str) else number(v) for v in values])


def direction(rng, tilt):
    """A vector up to `tilt` off the z axis in x and y."""
    return rng.uniform(-tilt, tilt), rng.uniform(-tilt, tilt), 1.0


def solid(rng, name, kind, x, y, r):
    """One solid of about half width r over (x, y)."""
    z = rng.uniform(-0.4, 0.4) * r
    turn = rng.uniform(0, 2 * math.pi)

    def ring(count, radius):
        angles = [turn + 2 * math.pi * k / count for k in range(count)]
        return [(x + radius * math.cos(a), y + radius * math.sin(a), z) for a in angles]

    def points(corners):
        return [statement("P%d" % (k + 1), *p) for k, p in enumerate(corners)]

    at = statement("P1", x, y, z)
    across = statement("LVE", math.cos(turn), math.sin(turn), 0.1)
    axis = statement("NOR", *direction(rng, 0.4))
    height = rng.uniform(0.6, 1.2) * r
    if kind == 0:
        return [name + ",SPHER,1", at, statement("RAD", 0.8 * r)]
    if kind == 1:
        return [name + ",R-CYLI,2", at, axis, statement("RAD", 0.7 * r), statement("LEN", height)]
    if kind == 2:
        return [name + ",R-CONE,2", at, axis, statement("RAD", 0.9 * r), statement("LEN", 1.5 * height)]
    if kind == 3:
        return [name + ",4-PRIS,2"] + points(ring(4, r)) + [statement("HEI", height)]
    if kind == 4:
        return [name + ",3-PRIS,2"] + points(ring(3, r)) + [statement("HEI", height)]
    if kind == 5:
        return [name + ",PYRAM,2"] + points(ring(4, r)) + [statement("HEI", 1.5 * height)]
    if kind == 6:
        return [name + ",TETRA,2"] + points(ring(3, r)) + [statement("HEI", 1.5 * height)]
    if kind == 7:
        return [name + ",ELLIP,1", at, statement("V1", math.cos(turn), math.sin(turn), 0.2),
                statement("V2", *direction(rng, 0.4)), statement("A", r), statement("B", 0.6 * r),
                statement("C", 0.7 * r)]
    if kind == 8:
        return [name + ",E-CYLI,2", at, axis, across, statement("L-R", r), statement("S-R", 0.6 * r),
                statement("LEN", height)]
    if kind == 9:
        return [name + ",E-CONE,2", at, axis, across, statement("L-R", r), statement("S-R", 0.6 * r),
                statement("LEN", 1.5 * height)]
    top = (x, y, z + height)
    return [name + ",PARAB,1", statement("P1", *top), statement("P2", x, y, z), statement("RAD", 0.9 * r)]


KINDS = 11


def expression(terms):
    """The terms, on lines of about sixty columns."""
    lines = [""]
    for term in terms:
        if len(lines[-1]) > 60:
            lines.append("")
        lines[-1] += term
    return lines


def machining(side, spacing, tolerance):
    return ["MACHI-DEF", statement("X-RNG", 0, side), statement("Y-RNG", 0, side),
            statement("X-INT", spacing), statement("Y-INT", spacing), statement("TOLER", tolerance)]


def solids(count, warp):
    rng = random.Random(400)
    side = 1000.0 * math.sqrt(count / 400)
    cells = math.ceil(math.sqrt(count))
    cell = side / cells
    lines = ["$$ %d solids on %s x %s, made by scripts/make_parts.py" % (count, number(side), number(side)), "SOLID-DEF"]
    terms = ["B"]
    for k in range(count):
        x = (k % cells + rng.uniform(0.2, 0.8)) * cell
        y = (k // cells + rng.uniform(0.2, 0.8)) * cell
        name = "S%d" % (k + 1)
        lines += solid(rng, name, k % KINDS, x, y, rng.uniform(0.3, 0.6) * 50)
        terms.append(("-" if rng.random() < 0.3 else "+") + name)
    spans = max(1, round(side / 50))
    lines += ["BSURF-DEF", "FERGU,%d,%d" % (spans + 1, spans + 1)]
    step = side / spans
    for j in range(spans + 1):
        for i in range(spans + 1):
            x, y = i * step, j * step
            z = 6 * math.sin(x / 90) * math.cos(y / 70) + rng.uniform(-0.5, 0.5)
            if warp and 0 < i < spans and 0 < j < spans:
                x += rng.uniform(-0.08, 0.08) * step
                y += rng.uniform(-0.08, 0.08) * step
            lines.append(statement(number(x), y, z))
    return lines + ["BOOLE-DEF"] + expression(terms) + machining(side, 1, 0.02)


def pockets(radii):
    rng = random.Random(50)
    lines = ["$$ 50 sphere pockets and 50 bosses on a plate, made by scripts/make_parts.py", "SOLID-DEF"]
    terms = ["B"]
    for k in range(100):
        x = 20 * (k % 10) + rng.uniform(7, 13)
        y = 20 * (k // 10) + rng.uniform(7, 13)
        pocket = (k + k // 10) % 2 == 0
        name = "%s%d" % ("P" if pocket else "K", k + 1)
        if pocket:
            lines += [name + ",SPHER,1", statement("P1", x, y, rng.uniform(0, 2)),
                      statement("RAD", radii * rng.uniform(4, 7))]
        elif k % 3 == 0:
            lines += [name + ",R-CONE,1", statement("P1", x, y, -1), statement("P2", x, y, rng.uniform(6, 9)),
                      statement("RAD", radii * rng.uniform(4, 6))]
        else:
            lines += [name + ",R-CYLI,2", statement("P1", x, y, -1), "NOR,0,0,1",
                      statement("RAD", radii * rng.uniform(3, 6)), statement("LEN", rng.uniform(3, 6))]
        terms.append(("-" if pocket else "+") + name)
    lines += ["BSURF-DEF", "PLANE,0", "BOOLE-DEF"] + expression(terms)
    return lines + machining(200, 2, 0.02)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("part", choices=["pockets", "solids"])
    parser.add_argument("count", type=int, nargs="?", default=400)
    parser.add_argument("--warp", action="store_true")
    parser.add_argument("--radii", type=float, default=1.0, help="of pockets and bosses, times those of the part (1)")
    parser.add_argument("-o", "--output", help="file to write (default: standard output)")
    parser.add_argument("--compare", help="write nothing; fail unless this file is what would be written")
    options = parser.parse_args()
    if not 1 <= options.count <= 10000:
        parser.error("N is 1 to 10000")
    if not 0 < options.radii <= 1:
        parser.error("F is over 0, up to 1")
    lines = pockets(options.radii) if options.part == "pockets" else solids(options.count, options.warp)
    text = "\n".join(lines) + "\n"
    if options.compare:
        with open(options.compare, encoding="ascii", newline="") as file:
            if file.read() != text:
                sys.exit("%s is not what this script writes" % options.compare)
    elif options.output:
        with open(options.output, "w", encoding="ascii", newline="\n") as file:
            file.write(text)
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
