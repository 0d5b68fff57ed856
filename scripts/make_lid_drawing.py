#!/usr/bin/env python3
"""Draws docs/pictures/lid-drawing.svg: the drawing of docs/examples/lid.part with its dimensions, plan over front view.

usage: make_lid_drawing.py [OUT.svg]
"""
# SPDX-License-Identifier: Apache-2.0
import math
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
SCALE = 6  # pixels a millimetre
WIDTH, HEIGHT = 780, 720
PLAN, FRONT = (370, 235), (370, 640)  # where x = 0, y = 0 of the plan and x = 0, z = 0 of the front view lie


class Drawing:
    def __init__(self):
        self.parts = []

    def path(self, view, points, kind, closed=False):
        x0, y0 = view
        text = " L".join(f"{x0 + SCALE * x:.1f},{y0 - SCALE * y:.1f}" for x, y in points)
        self.parts.append(f'<path class="{kind}" d="M{text}{"Z" if closed else ""}"/>')

    def box(self, view, x, y, kind="edge"):
        self.path(view, [(-x, -y), (x, -y), (x, y), (-x, y)], kind, True)

    def curve(self, view, function, low, high, kind="edge", closed=False):
        steps = [low + (high - low) * k / 96 for k in range(97)]
        self.path(view, [function(t) for t in steps], kind, closed)

    def text(self, view, x, y, text, turn=0, anchor="middle"):
        px, py = view[0] + SCALE * x, view[1] - SCALE * y
        turned = f' transform="rotate({turn} {px:.1f} {py:.1f})"' if turn else ""
        self.parts.append(f'<text x="{px:.1f}" y="{py:.1f}" text-anchor="{anchor}"{turned}>{text}</text>')

    def arrow(self, view, tip, direction):
        (x, y), (dx, dy) = tip, direction
        side = [(x + 2 * dx + s * dy * 0.5, y + 2 * dy - s * dx * 0.5) for s in (1, -1)]
        self.path(view, [tip, *side], "head", True)

    def across(self, view, x0, x1, y, text, start):
        """A dimension along x at height y, its lines from the heights `start` of its two ends."""
        for x, from_y in zip((x0, x1), start):
            self.path(view, [(x, from_y), (x, y + math.copysign(1, y - from_y))], "thin")
        self.path(view, [(x0, y), (x1, y)], "thin")
        self.arrow(view, (x0, y), (1, 0))
        self.arrow(view, (x1, y), (-1, 0))
        self.text(view, (x0 + x1) / 2, y + 0.8, text)

    def up(self, view, x, y0, y1, text, start):
        """A dimension along y at x."""
        for y, from_x in zip((y0, y1), start):
            self.path(view, [(from_x, y), (x + math.copysign(1, x - from_x), y)], "thin")
        self.path(view, [(x, y0), (x, y1)], "thin")
        self.arrow(view, (x, y0), (0, 1))
        self.arrow(view, (x, y1), (0, -1))
        self.text(view, x - 0.8, (y0 + y1) / 2, text, turn=-90)

    def note(self, view, at, to, text):
        self.path(view, [at, to], "thin")
        self.text(view, to[0] + 0.8, to[1] - 0.6, text, anchor="start")

    def svg(self):
        style = ("svg{background:#fff}path{fill:none;stroke:#222}.edge{stroke-width:1.8}.thin{stroke-width:.7}.hidden{stroke-width:.9;"
                 "stroke-dasharray:5 3}.axis{stroke-width:.7;stroke-dasharray:12 3 3 3}.head{fill:#222;stroke:none}"
                 "text{font:14px sans-serif;fill:#222}")
        return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}">'
                f"<style>{style}</style>\n" + "\n".join(self.parts) + "\n</svg>\n")


def plan(d):
    v = PLAN
    d.box(v, 45, 30)
    d.box(v, 30, 18)
    d.box(v, 25, 13)
    for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        d.path(v, [(30 * x, 18 * y), (25 * x, 13 * y)], "edge")
    # The dome's foot on the block, where (x/20)² + (y/10)² = 1 - (2/7)²; the groove's sides there are 3.606 off its axis.
    foot = math.sqrt(1 - (2 / 7) ** 2)
    half = math.sqrt(49 - 36)
    turn = math.acos(half / (20 * foot))
    for side in (0, math.pi):
        d.curve(v, lambda t, side=side: (20 * foot * math.cos(t + side), 10 * foot * math.sin(t + side)), -turn, turn)
    for x in (-half, half):
        d.path(v, [(x, 10 * foot), (x, 13)], "edge")
        d.path(v, [(x, -10 * foot), (x, -13)], "edge")
    for x in (-37, 37):
        d.curve(v, lambda t, x=x: (x + 5 * math.cos(t), 5 * math.sin(t)), 0, 2 * math.pi, closed=True)
    d.path(v, [(-48, 0), (48, 0)], "axis")
    d.path(v, [(0, -33), (0, 33)], "axis")
    d.across(v, -45, 45, 36, "90", (30, 30))
    d.across(v, -37, 37, -34, "74", (0, 0))
    d.up(v, -56, -30, 30, "60", (-45, -45))
    d.up(v, -51, -18, 18, "36", (-30, -30))
    d.up(v, 53, -13, 13, "26", (25, 25))
    d.note(v, (37 + 5 * math.cos(1), 5 * math.sin(1)), (23, 22), "2 cones, dia. 10, 10 high")
    d.note(v, (-14, 10 * math.sqrt(foot**2 - 0.49)), (-35, 23), "half axes 20, 10, 7")


def front(d):
    v = FRONT
    d.path(v, [(-45, 0), (-45, -6), (45, -6), (45, 0)], "edge")
    d.path(v, [(-45, 0), (-42, 0)], "edge")
    d.path(v, [(42, 0), (45, 0)], "edge")
    d.path(v, [(-32, 0), (-30, 0), (-25, 14), (-18.9, 14)], "edge")
    d.path(v, [(18.9, 14), (25, 14), (30, 0), (32, 0)], "edge")
    for x in (-37, 37):
        d.path(v, [(x - 5, 0), (x, 10), (x + 5, 0)], "edge")

    def dome(x):
        return 12 + 7 * math.sqrt(1 - (x / 20) ** 2)

    def groove(x):
        return 20 - math.sqrt(49 - x * x)

    meet = next(x / 1000 for x in range(7000) if groove(x / 1000) >= dome(x / 1000))
    d.curve(v, lambda x: (x, dome(x)), -19.16, -meet)
    d.curve(v, lambda x: (x, dome(x)), meet, 19.16)
    d.curve(v, lambda x: (x, groove(x)), -meet, meet)
    d.curve(v, lambda t: (7 * math.cos(t), 20 + 7 * math.sin(t)), 0, 2 * math.pi, "hidden", True)
    d.path(v, [(0, -9), (0, 30)], "axis")
    d.path(v, [(-9, 20), (9, 20)], "axis")
    d.across(v, -30, 30, -11, "60", (0, 0))
    d.across(v, -25, 25, 30, "50", (14, 14))
    d.up(v, -56, 0, 14, "14", (-30, -25))
    d.up(v, -51, 0, 10, "10", (-45, -37))
    d.up(v, 51, 0, 20, "20", (45, 0))
    d.up(v, 56, 0, 12, "12", (45, 20))
    d.note(v, (7 * math.cos(0.7), 20 + 7 * math.sin(0.7)), (11, 26), "R7")


def main():
    out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs/pictures/lid-drawing.svg"
    drawing = Drawing()
    plan(drawing)
    front(drawing)
    out.write_text(drawing.svg())


if __name__ == "__main__":
    main()
