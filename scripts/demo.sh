#!/usr/bin/env bash
# From an empty checkout to the paper's die in files for other CAD tools: installs what is missing, builds, exports.
# usage: scripts/demo.sh        writes out/fig6.stl .obj .mtl .ply .glb, and out/fig6.html, which shows it in a browser
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh --minimal
echo "demo: building build/release/bin/diesink"
mkdir -p build out
log=build/demo.log
if ! { cmake --preset release -DDIESINK_BUILD_TESTS=OFF -DDIESINK_BUILD_BENCH=OFF &&
       cmake --build --preset release --target diesink; } >"$log" 2>&1; then
  tail -n 40 "$log" >&2
  echo "demo: the build failed (whole output in $log)" >&2
  exit 1
fi
echo "demo: tessellating fixtures/parts/fig6.part"
build/release/bin/diesink export fixtures/parts/fig6.part -o out/fig6.stl -o out/fig6.obj -o out/fig6.ply -o out/fig6.glb
build/release/bin/diesink view fixtures/parts/fig6.part -o out/fig6.html
echo "demo: done; open out/fig6.html in a browser, or ask build/release/bin/diesink --help"
