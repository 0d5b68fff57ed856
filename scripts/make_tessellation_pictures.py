#!/usr/bin/env python3
"""Draws docs/pictures/tessellation_*.svg: triangles, creases (blue), walls (red) and borders (black) in plan.

Needs a release build of diesink and tessellation_soak. Usage: scripts/make_tessellation_pictures.py
"""
# SPDX-License-Identifier: Apache-2.0
import os
import subprocess
import tempfile

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BIN = os.path.join(ROOT, "build", "release", "bin")
OUT = os.path.join(ROOT, "docs", "pictures")
CASES = ["HemisphereBoss", "SphereOnPlane", "SpheresSideBySide", "SteinmetzJustSmaller", "CylinderOnCylinder",
         "OverlappingFlushBoxes", "ConcentricCylinders", "ConeLeaningWithOverhang", "ThreeSpheresThroughOnePoint",
         "FadingJump", "FadingJumpOfASphere", "GrooveAcrossADome", "SliverOfPlaneBetweenCylinders", "IslandInAPocket",
         "RimTouchingTheBorder", "OverhangOverAStep", "CreaseAHairBesideARim", "SpheresTouchingRoundAHole",
         "WallsAndRimsOnGridLines", "PyramidsMeetingInAnApex"]
INK = {"crease": ("#1559c8", 1.1), "wall": ("#d02020", 1.1), "border": ("#000000", 1.1), "inside": ("#b8b8b8", 0.3)}


def mesh_of(part, tolerance, folder):
    """Vertices and (triangle, element) of a part, or None where it cannot be tessellated."""
    path = os.path.join(folder, "mesh.obj")
    done = subprocess.run([os.path.join(BIN, "diesink"), "export", part, "-o", path, "--tolerance", str(tolerance),
                           "--quiet"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=60, check=False)
    if done.returncode not in (0, 5):
        return None
    vertices, faces, element = [], [], ""
    with open(path, encoding="utf-8") as file:
        for line in file:
            words = line.split()
            if not words:
                continue
            if words[0] == "v":
                vertices.append(tuple(float(w) for w in words[1:4]))
            elif words[0] == "g":
                element = words[1] if len(words) > 1 else ""
            elif words[0] == "f":
                faces.append(([int(w.split("/")[0]) - 1 for w in words[1:4]], element))
    return vertices, faces


def sides_of(faces):
    """Every side once, with its kind."""
    elements = {}
    for corners, element in faces:
        for k in range(3):
            a, b = corners[k], corners[(k + 1) % 3]
            elements.setdefault((min(a, b), max(a, b)), []).append(element)
    kinds = {"inside": [], "crease": [], "wall": [], "border": []}
    for side, found in elements.items():
        walls = sum(e.endswith(".wall") for e in found)
        if walls == len(found) and walls > 1:
            continue  # inside a wall
        kind = "border" if len(found) == 1 else "wall" if walls else "crease" if len(set(found)) > 1 else "inside"
        kinds[kind].append(side)
    return kinds


def drawing(mesh, size, left, top, project):
    """The strokes of one mesh in a square of the given size."""
    vertices, faces = mesh
    points = [project(v) for v in vertices]
    low = [min(p[k] for p in points) for k in (0, 1)]
    scale = size / max(max(p[k] for p in points) - low[k] for k in (0, 1))
    place = [(left + (x - low[0]) * scale, top + size - (y - low[1]) * scale) for x, y in points]
    text = []
    for kind, sides in sides_of(faces).items():
        path = "".join("M%.1f %.1fL%.1f %.1f" % (place[a] + place[b]) for a, b in sides if place[a] != place[b])
        colour, width = INK[kind]
        text.append('<path d="%s" stroke="%s" stroke-width="%g" fill="none"/>' % (path, colour, width))
    return "\n".join(text)


def write(name, width, height, body):
    with open(os.path.join(OUT, name), "w", encoding="utf-8") as file:
        file.write('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 %d %d" font-family="sans-serif" '
                   'font-size="11">\n<rect width="100%%" height="100%%" fill="white"/>\n%s\n</svg>\n'
                   % (width, height, body))


def plan(v):
    return v[0], v[1]


def aslant(v):
    return v[0] * 0.82 - v[1] * 0.57, v[0] * 0.3 + v[1] * 0.43 + v[2] * 0.85


def main():
    os.makedirs(OUT, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        fig6 = mesh_of(os.path.join(ROOT, "fixtures", "parts", "fig6.part"), 0.1, folder)
        write("tessellation_fig6.svg", 840, 440,
              drawing(fig6, 400, 10, 20, plan) + "\n" + drawing(fig6, 400, 430, 20, aslant))
        subprocess.run([os.path.join(BIN, "tessellation_soak"), "--cases", folder], check=True)
        body, shown = [], 0
        for case in CASES:
            mesh = mesh_of(os.path.join(folder, case + ".part"), 0.2, folder)
            if mesh is None:
                print("not drawn: " + case)
                continue
            left, top = 10 + 210 * (shown % 4), 10 + 225 * (shown // 4)
            body.append(drawing(mesh, 195, left, top, plan))
            body.append('<text x="%d" y="%d">%s</text>' % (left, top + 210, case))
            shown += 1
        write("tessellation_cases.svg", 850, 15 + 225 * ((shown + 3) // 4), "\n".join(body))


if __name__ == "__main__":
    main()
