#!/usr/bin/env python3
"""Writes random part programs as a drawing office makes them: what tests/support/random_program.h never draws.

  make_dies.py aligned FIRST COUNT FOLDER   blocks, bars, cones, domes on round numbers: tops flush, walls on
                                            grid lines and on the border, cylinders tangent, solids repeated
  make_dies.py rounded FIRST COUNT FOLDER   rounded edges of bars, balls and blocks, turned in plan or leaning,
                                            coordinates rounded to six decimals
  make_dies.py fine FIRST COUNT FOLDER      features from 1e-4 to 1 of the part's size on one another

Each seed of FIRST..FIRST+COUNT-1 makes FOLDER/KIND<seed>.part; the same seed gives the same text."""
# SPDX-License-Identifier: Apache-2.0
import argparse
import math
import pathlib
import random


def number(value):
    return repr(round(value, 6) + 0.0)


def statement(keyword, *values):
    return ",".join([keyword] + [number(v) for v in values])


class Die:
    """The lines of one part program while it grows."""

    def __init__(self, rng):
        self.rng = rng
        self.solids = []
        self.terms = []
        self.count = 0

    def add(self, sign, kind, option, *statements):
        self.count += 1
        name = f"S{self.count}"
        self.solids += [f"{name},{kind},{option}", *statements]
        self.terms.append((sign, name))
        return name

    def block(self, sign, low, high):
        return self.add(sign, "4-PRIS", 3, statement("P1", *low), statement("P2", *high))

    def prism(self, sign, ring, height):
        return self.add(sign, "4-PRIS", 2, *[statement(f"P{k + 1}", *p) for k, p in enumerate(ring)],
                        statement("HEI", height))

    def bar(self, sign, one, other, radius):
        return self.add(sign, "R-CYLI", 1, statement("P1", *one), statement("P2", *other), statement("RAD", radius))

    def ball(self, sign, centre, radius):
        return self.add(sign, "SPHER", 1, statement("P1", *centre), statement("RAD", radius))

    def cone(self, sign, base, apex, radius):
        return self.add(sign, "R-CONE", 1, statement("P1", *base), statement("P2", *apex), statement("RAD", radius))

    def text(self, head, base, domain, tolerance):
        expression, line = [], ""
        terms = ([("", "B")] if base else []) + self.terms
        for k, (sign, name) in enumerate(terms):
            line += ("" if k == 0 and sign in "+" else sign) + name
            if len(line) > 60:
                expression.append(line)
                line = ""
        x0, x1, y0, y1 = domain
        return "\n".join([f"$$ {head}", "SOLID-DEF", *self.solids, *base, "BOOLE-DEF", *expression, *([line] if line else []),
                          "MACHI-DEF", statement("X-RNG", x0, x1), statement("Y-RNG", y0, y1),
                          statement("X-INT", (x1 - x0) / 40), statement("Y-INT", (y1 - y0) / 40),
                          statement("TOLER", tolerance)]) + "\n"


def ferguson(rng, side, rows, height, warp):
    lines = ["BSURF-DEF", f"FERGU,{rows},{rows}"]
    step = side / (rows - 1)
    for j in range(rows):
        for i in range(rows):
            x, y = i * step, j * step
            if warp and 0 < i < rows - 1 and 0 < j < rows - 1:
                x += rng.uniform(-0.15, 0.15) * step
                y += rng.uniform(-0.15, 0.15) * step
            lines.append(",".join(map(number, (x, y, rng.choice([0, 1, 2, 0.5]) * height))))
    return lines


def base_of(rng, side, flat):
    """Lines of a base surface: a flat one at z = 0 with the chance `flat`."""
    if rng.random() < flat:
        return ["BSURF-DEF", "PLANE,0"]
    kind = rng.randrange(3)
    if kind == 0:
        return ["BSURF-DEF", "PLANE", statement("P1", side / 2, side / 2, 0),
                statement("NOR", rng.choice([-.2, -.1, 0, .1]), rng.choice([-.1, 0, .05, .2]), 1)]
    return ferguson(rng, side, rng.choice([2, 3, 5]), side / 60, kind == 2)


def aligned(rng):
    die = Die(rng)
    side = 100.0
    step = rng.choice([2.5, 5.0, 10.0])
    cells = int(side / step)

    def on(low=0, high=None):
        return step * rng.randint(low, cells if high is None else high)

    def size():
        return step * rng.choice([1, 1, 2, 2, 3, 4]) * rng.choice([0.5, 1, 1])

    for _ in range(rng.randint(2, 9)):
        sign = "+" if not die.terms or rng.random() < 0.65 else "-"
        x, y, r, h = on(), on(), size(), size()
        z = rng.choice([0, 0, 0, step, h, -step])
        kind = rng.randrange(10)
        along = rng.choice([(1, 0), (0, 1), (1, 1), (1, -1)])
        if kind <= 1:
            low = (x, y, z - (h if sign == "-" else 0))
            die.block(sign, low, (x + size(), y + size(), z + h))
        elif kind == 2:
            die.bar(sign, (x, y, z - h), (x, y, z + h), r)
        elif kind == 3:
            length = step * rng.randint(1, 8)
            die.bar(sign, (x, y, z), (x + along[0] * length, y + along[1] * length, z + rng.choice([0, 0, 0, h])), r)
        elif kind == 4:
            die.cone(sign, (x, y, z), (x, y, z + rng.choice([1, 1, -1]) * rng.choice([r, h, 2 * r])), r)
        elif kind == 5:
            die.cone(sign, (x, y, z), (x + along[0] * r, y + along[1] * r, z + rng.choice([0, r, h])), r)
        elif kind == 6:
            die.ball(sign, (x, y, z), r)
        elif kind == 7:
            die.add(sign, "ELLIP", 2, statement("P1", x, y, z), statement("A", r), statement("B", rng.choice([r, h])),
                    statement("C", h))
        elif kind == 8:
            up = rng.choice([1, -1])
            die.add(sign, "PARAB", 1, statement("P1", x, y, z + up * h), statement("P2", x, y, z), statement("RAD", r))
        else:
            lean = rng.choice([0, 0, r, r / 2])
            die.add(sign, "4-PRIS", 1,
                    *[statement(f"P{k + 1}", x + a * 2 * r, y + b * 2 * r, z)
                      for k, (a, b) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)])],
                    *[statement(f"P{k + 5}", x + a * (2 * r - lean), y + b * (2 * r - lean), z + h)
                      for k, (a, b) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)])])
        if rng.random() < 0.1:
            die.terms.append((rng.choice("+-"), rng.choice(die.terms)[1]))
    base = base_of(rng, side, 0.6) if rng.random() < 0.85 else []
    domain = (0, side, 0, side) if rng.random() < 0.7 else (step, side - step, 0, side / 2)
    return die.text("blocks, bars, cones and domes on round numbers", base, domain, rng.choice([0.01, 0.05, 0.2]))


def turned(rng, degrees_of, lean):
    """A turn about z and then a lean about x, about the origin."""
    a, b = math.radians(degrees_of), math.radians(lean)

    def turn(p):
        x, y, z = p
        y, z = y * math.cos(b) - z * math.sin(b), y * math.sin(b) + z * math.cos(b)
        return x * math.cos(a) - y * math.sin(a), x * math.sin(a) + y * math.cos(a), z
    return turn


def rounded_block(die, sign, place, turn, half, height, radius, foot):
    """A block whose upper (or, cut out, lower) edges and whose upright corners are round: bars, balls, prisms."""
    def at(x, y, z):
        p = turn((x, y, z))
        return tuple(a + b for a, b in zip(place, p))
    hx, hy = half
    up = 1 if sign == "+" else -1
    top = up * height
    inner = top - up * radius
    corners = [(-hx, -hy), (hx, -hy), (hx, hy), (-hx, hy)]
    low, high = sorted((-up * foot, inner))
    # The core in three blocks, as they are drawn: full height inside the edges, then the two pairs of sides.
    def slab(x, y, z0, z1):
        die.prism(sign, [at(-x, -y, z0), at(x, -y, z0), at(x, y, z0), at(-x, y, z0)], z1 - z0)
    slab(hx, hy, *sorted((-up * foot, top)))
    slab(hx + radius, hy, low, high)
    slab(hx, hy + radius, low, high)
    for k, (x, y) in enumerate(corners):
        nx, ny = corners[(k + 1) % 4]
        die.bar(sign, at(x, y, inner), at(nx, ny, inner), radius)
        die.bar(sign, at(x, y, low if up > 0 else high), at(x, y, inner), radius)
        die.ball(sign, at(x, y, inner), radius)


def slot(die, sign, one, other, radius):
    """A groove (or a rib) with ball ends."""
    die.bar(sign, one, other, radius)
    die.ball(sign, one, radius)
    die.ball(sign, other, radius)


def rounded(rng):
    die = Die(rng)
    side = 100.0
    for _ in range(rng.randint(1, 4)):
        sign = "+" if not die.terms or rng.random() < 0.6 else "-"
        place = (rng.uniform(15, 85), rng.uniform(15, 85), rng.choice([0, 0, rng.uniform(-2, 6)]))
        turn = turned(rng, rng.choice([0, 90, 45, rng.uniform(0, 90)]), rng.choice([0, 0, 0, rng.uniform(-12, 12)]))
        if rng.random() < 0.55:
            radius = rng.choice([1, 2, 3, rng.uniform(0.5, 4)])
            rounded_block(die, sign, place, turn, (rng.uniform(3, 18), rng.uniform(3, 18)),
                          radius + rng.choice([0, rng.uniform(1, 10)]), radius, rng.uniform(0.5, 4))
        else:
            length, radius = rng.uniform(5, 30), rng.choice([2, 3, rng.uniform(1, 6)])
            ends = [tuple(a + b for a, b in zip(place, turn((s * length, 0, rng.choice([0, s]) * rng.uniform(0, 3)))))
                    for s in (-1, 1)]
            slot(die, sign, *ends, radius)
            if rng.random() < 0.3:  # another one that goes on from its end
                third = tuple(a + b for a, b in zip(ends[1], turn((rng.choice([0, 5]), rng.uniform(5, 20), 0))))
                slot(die, sign, ends[1], third, radius)
    base = base_of(rng, side, 0.7) if rng.random() < 0.9 else []
    return die.text("rounded edges of bars, balls and blocks", base, (0, side, 0, side), rng.choice([0.01, 0.02, 0.05]))


def fine(rng):
    die = Die(rng)
    side = 100.0

    def small():
        return side * 10 ** rng.uniform(-4, -0.5)

    spots = [(rng.uniform(10, 90), rng.uniform(10, 90), rng.uniform(-1, 3)) for _ in range(rng.randint(1, 3))]
    for _ in range(rng.randint(2, 10)):
        sign = "+" if not die.terms or rng.random() < 0.6 else "-"
        x, y, z = rng.choice(spots)
        r, h = small(), small()
        x, y, z = x + rng.choice([0, 0, 1, -1]) * small(), y + rng.choice([0, 0, 1, -1]) * small(), z
        kind = rng.randrange(6)
        if kind == 0:
            die.ball(sign, (x, y, z), r)
        elif kind == 1:
            die.block(sign, (x - r, y - h, z - small()), (x + small(), y + h, z + small()))
        elif kind == 2:
            die.bar(sign, (x - h, y, z), (x + h, y + rng.choice([0, h]), z), r)
        elif kind == 3:
            die.bar(sign, (x, y, z - h), (x, y, z + small()), r)
        elif kind == 4:
            die.cone(sign, (x, y, z), (x, y, z + rng.choice([1, 1, -1]) * h), r)
        else:
            die.add(sign, "ELLIP", 2, statement("P1", x, y, z), statement("A", r), statement("B", h), statement("C", small()))
    return die.text("small on large", base_of(rng, side, 0.4), (0, side, 0, side), rng.choice([0.002, 0.02, 0.1]))


KINDS = {"aligned": aligned, "rounded": rounded, "fine": fine}


def write(kind, seed, folder):
    """The path of the die, written to the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{kind}{seed}.part"
    path.write_text(KINDS[kind](random.Random(f"{kind} {seed}")))
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("folder", type=pathlib.Path)
    options = parser.parse_args()
    for seed in range(options.first, options.first + options.count):
        write(options.kind, seed, options.folder)


if __name__ == "__main__":
    main()
