#!/usr/bin/env python3
"""Takes the pictures of docs/viewer.md in a headless Chromium.

usage: make_viewer_pictures.py [PROGRAM]    (default build/release/bin/diesink; writes docs/pictures)
"""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/convert"))
from browser import Browser  # noqa: E402

SIZE = (900, 600)


def main():
    program = sys.argv[1] if len(sys.argv) > 1 else ROOT / "build/release/bin/diesink"
    fig6 = ROOT / "fixtures/parts/fig6.part"
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)

        def run(*words):
            subprocess.run([program, *map(str, words), "--quiet"], check=True)

        def picture(name, words, *scripts, dark=False):
            run("view", *words, "-o", folder / "die.html")
            with Browser(SIZE, dark) as browser:
                assert browser.open(folder / "die.html") == "open"
                for script in scripts:
                    browser.run(script)
                browser.frame()
                (ROOT / f"docs/pictures/{name}.png").write_bytes(browser.png())

        run("cl", fig6, "--cutter", "3,1.5", "--cusp", "0.05", "-o", folder / "path.apt")
        run("export", fig6, "-o", folder / "coarse.stl", "--tolerance", "0.15")
        picture("view-light", [fig6, folder / "path.apt"], "diesink.viewer.setPath(() => diesink.viewer.path.set(0.42))")
        picture("view-section", [fig6], "document.querySelector(`[data-axis='1']`).click()", dark=True)
        picture("view-cut", [fig6, folder / "path.apt", "--verify"],
                "diesink.viewer.setPath(() => diesink.viewer.path.set(0.42))")
        picture("view-deviation", [fig6, folder / "coarse.stl"])


if __name__ == "__main__":
    main()
