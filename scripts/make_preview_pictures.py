#!/usr/bin/env python3
"""Draws the pictures of README.md, its example's among them, and of the primitives in docs/part-program.md, and of docs/scanned-base.md, by diesink preview.

usage: make_preview_pictures.py [PROGRAM]    (default build/release/bin/diesink; writes docs/pictures)
"""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent

# Each on a plane of 40 x 40 at z = 0; the names are those of the pictures.
PRIMITIVES = {
    "tetra": "TETRA,2\nP1,8,10,0\nP2,33,14,0\nP3,16,34,0\nHEI,20",
    "3-pris": "3-PRIS,1\nP1,6,8,0\nP2,35,12,0\nP3,17,35,0\nP4,13,13,12\nP5,27.5,15,12\nP6,18.5,26.5,12",
    "pyram": "PYRAM,2\nP1,7,9,0\nP2,32,7,0\nP3,34,31,0\nP4,9,33,0\nHEI,20",
    "4-pris": "4-PRIS,1\nP1,6,6,0\nP2,34,6,0\nP3,34,34,0\nP4,6,34,0\nP5,11,11,12\nP6,29,11,12\nP7,29,29,12\nP8,11,29,12",
    "r-cone": "R-CONE,2\nP1,20,20,0\nNOR,0,0,1\nRAD,14\nLEN,22",
    "r-cyli": "R-CYLI,1\nP1,4,12,3\nP2,34,28,3\nRAD,9",
    "e-cone": "E-CONE,2\nP1,20,20,0\nNOR,0,0,1\nLVE,1,-.4,0\nL-R,17\nS-R,9\nLEN,22",
    "e-cyli": "E-CYLI,2\nP1,20,20,-1\nNOR,0,0,1\nLVE,1,-.4,0\nL-R,16\nS-R,9\nLEN,12",
    "spher": "SPHER,1\nP1,20,20,2\nRAD,14",
    "ellip": "ELLIP,1\nP1,20,20,2\nV1,-.3,1,0\nV2,.3,0,1\nA,16\nB,10\nC,9",
    "parab": "PARAB,1\nP1,20,20,18\nP2,20,20,-4\nRAD,15",
}
ON_A_PLANE = """SOLID-DEF
S1,{solid}
BSURF-DEF
PLANE,0
BOOLE-DEF
B+S1
MACHI-DEF
X-RNG,0,40
Y-RNG,0,40
"""


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/diesink"
    pictures = ROOT / "docs/pictures"
    pictures.mkdir(exist_ok=True)

    def draw(part, name, *options):
        subprocess.run([program, "preview", part, "-o", pictures / f"{name}.png", *options], check=True)

    fig6 = ROOT / "fixtures/parts/fig6.part"
    draw(fig6, "fig6", "--size", "960x720")
    draw(fig6, "fig6-plan", "--size", "480x360", "--view", "plan")
    draw(fig6, "fig6-slope", "--size", "480x360", "--color", "slope")
    draw(ROOT / "docs/examples/lid.part", "lid", "--size", "640x480")
    with tempfile.TemporaryDirectory() as folder:
        for name, solid in PRIMITIVES.items():
            part = pathlib.Path(folder) / f"{name}.part"
            part.write_text(ON_A_PLANE.format(solid=solid))
            draw(part, f"solid-{name}", "--size", "200x150", "--bare")
        # The worked example of docs/scanned-base.md, its part program as the page has it.
        page = (ROOT / "docs/scanned-base.md").read_text()
        scan, part = pathlib.Path(folder) / "die_scan.stl", pathlib.Path(folder) / "scanned_die.part"
        subprocess.run([sys.executable, ROOT / "scripts/make_scan.py", scan], check=True)
        part.write_text(page.split("```part file=scanned_die.part\n")[1].split("```")[0])
        draw(scan, "scanned-scan", "--size", "640x400")
        draw(part, "scanned-die", "--size", "900x560")


if __name__ == "__main__":
    main()
