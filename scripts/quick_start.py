#!/usr/bin/env python3
"""Writes the project that a page of the docs shows: the first cmake block as CMakeLists.txt, the first cpp block as quick_start.cpp.

usage: quick_start.py PAGE.md FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re
import sys


def main():
    page, folder = map(pathlib.Path, sys.argv[1:3])
    for language, name in (("cmake", "CMakeLists.txt"), ("cpp", "quick_start.cpp")):
        block = re.search(rf"^```{language}\n(.*?)^```", page.read_text(), re.M | re.S)
        if block is None:
            sys.exit(f"{page}: no block of {language}")
        (folder / name).write_text(block.group(1))


if __name__ == "__main__":
    main()
