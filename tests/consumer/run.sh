#!/usr/bin/env bash
# Installs a build into an empty prefix, builds the project of docs/cpp.md against it and runs that.
# usage: run.sh BUILD_FOLDER CXX_COMPILER
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
top=$(cd "$(dirname "$0")/../.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$1" --prefix "$scratch/prefix" >/dev/null
"$scratch/prefix/bin/diesink" --version
mkdir "$scratch/project"
"$top/scripts/quick_start.py" "$top/docs/cpp.md" "$scratch/project"
cmake -S "$scratch/project" -B "$scratch/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER="$2" \
  -DCMAKE_PREFIX_PATH="$scratch/prefix" >/dev/null
cmake --build "$scratch/build" >/dev/null
cd "$scratch"
build/quick_start "$top/fixtures/parts/fig6.part" | tee said
[ "$(wc -l <said)" -eq 3 ]
prefix/bin/diesink info quick_start.stl --json >/dev/null
# What is wrong with a part program ends the project's program with a message and its place.
! build/quick_start "$top/fixtures/broken/radius_zero.part" 2>wrong
grep -q 'radius_zero.part:[0-9]*:[0-9]*: error: ' wrong
