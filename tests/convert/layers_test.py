#!/usr/bin/env python3
"""python -> convert -> picture -> formats -> core, never back; core knows no files, streams or environment.

usage: layers_test.py SOURCE_FOLDER
"""
# SPDX-License-Identifier: Apache-2.0
import pathlib
import re
import sys

LAYERS = ["core", "formats", "picture", "viewer", "convert", "python"]  # each may include itself and those before it
# What core may not touch at all: files, streams, the environment, the command line's and the formats' libraries.
CORE_FORBIDDEN = re.compile(
    r"#include <(iostream|fstream|sstream|ostream|istream|filesystem|cstdio|stdio\.h|unistd\.h|fcntl\.h|CLI/|draco/|tiny_gltf|nlohmann/)"
    r"|\b(getenv|fopen|printf|std::cout|std::cerr)\b")
CLI11_OUTSIDE = re.compile(r"#include <CLI/")
INCLUDE = re.compile(r'#include "([a-z_]+)/')
SYSTEM_INCLUDE = re.compile(r"#include <([A-Za-z_0-9]+)/")
# Public headers name no third party but Eigen, whose fixed-size vectors they use.
PUBLIC_THIRD_PARTY = {"Eigen", "sys"}
# The check of tool paths shares the cutter's shape with their planning and nothing else.
MACHINING = "core/machining"
CHECKING = {"cell_bounds", "gouge_search", "height_pyramid", "lattice_check", "move_merger", "plan_clip", "point_depths", "sweep_depth", "swept_heights", "verify"}
SHARED = {"cutter", "wide_surface"}  # the second is the surface that both are given


def machining_faults(root):
    files = sorted(p for p in (root / MACHINING).iterdir() if p.suffix in (".h", ".cpp"))
    missing = (CHECKING | SHARED) - {p.stem for p in files}
    if missing:
        yield f"{MACHINING}: no {', '.join(sorted(missing))}; the layers of the check are not known"
    for path in files:
        if path.stem in SHARED:
            allowed = SHARED
        elif path.stem in CHECKING:
            allowed = CHECKING | {"cutter"}
        else:
            allowed = {p.stem for p in files} - CHECKING
        for number, line in enumerate(path.read_text().splitlines(), 1):
            for name in re.findall(rf'#include "{MACHINING}/(\w+)\.h"', line):
                if name not in allowed:
                    yield f"{path.relative_to(root)}:{number}: planning and checking know each other: {line.strip()}"


def public_headers(folder):
    """The headers of the installed file sets: every .h a CMakeLists.txt names."""
    for listing in folder.rglob("CMakeLists.txt"):
        for name in re.findall(r"[\w/]+\.h\b", listing.read_text()):
            yield listing.parent / name


def faults(root):
    for place, layer in enumerate(LAYERS):
        allowed = set(LAYERS[: place + 1])
        public = set(public_headers(root / layer))
        files = sorted(p for p in (root / layer).rglob("*") if p.suffix in (".h", ".cpp", ".inc"))
        if not files:
            yield f"{layer}: no sources found"
        for path in files:
            for number, line in enumerate(path.read_text().splitlines(), 1):
                where = f"{path.relative_to(root)}:{number}"
                code = line.split("//")[0]
                for folder in INCLUDE.findall(code):
                    if folder not in allowed:
                        yield f"{where}: {layer} includes {folder}: {line.strip()}"
                if layer == "core" and CORE_FORBIDDEN.search(code):
                    yield f"{where}: core knows no files, streams or environment: {line.strip()}"
                if layer != "convert" and CLI11_OUTSIDE.search(code):
                    yield f"{where}: only convert knows CLI11: {line.strip()}"
                if path in public:
                    for library in SYSTEM_INCLUDE.findall(code):
                        if library not in PUBLIC_THIRD_PARTY:
                            yield f"{where}: a public header names {library}: {line.strip()}"


def main():
    root = pathlib.Path(sys.argv[1])
    found = list(faults(root)) + list(machining_faults(root))
    for each in found:
        print(each)
    print(f"{len(found)} includes against the layers")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
