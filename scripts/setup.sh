#!/usr/bin/env bash
# Installs the Debian packages diesink is built and tested with; installs nothing that is there already.
# usage: scripts/setup.sh [--minimal | --bench]
#   (nothing)   what the build and the tests need
#   --minimal   what the build alone needs
#   --bench     the build, the tests and the benchmarks with their peers
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail

build=(
  g++ cmake ninja-build
  libeigen3-dev        # fixed-size vectors
  libhwy-dev           # SIMD with run-time dispatch
  libcli11-dev         # command line
  libdraco-dev         # compressed glTF
  libtinygltf-dev      # glTF reader and writer (headers only)
  nlohmann-json3-dev   # JSON of glTF
  libmeshoptimizer-dev # EXT_meshopt_compression
  libpng-dev           # pictures
  zlib1g-dev           # what is in the viewer's pages
  esbuild libjs-three  # make the viewer's page of its sources; without them the program has no view
)
tests=(
  libgtest-dev         # unit tests
  libassimp-dev        # second reader of STL, OBJ, PLY and OFF
  libopenmesh-dev      # second reader and writer of the same, peer of the STL reader in bench
  python3              # drives the program
  pybind11-dev python3-dev python3-numpy python3-pytest # the Python module and its tests
  dpkg-dev             # dependencies of the packages
  file                 # what cpack asks for the kind of each file when it looks for shared libraries
  locales              # a locale with a decimal comma
)
# The second readers of glTF (tests/formats/npm) run on any Node.js with npm.
command -v npm >/dev/null || tests+=(nodejs npm)
# Where it cannot be had, the test that looks at the viewer's page says that it is skipped.
if_there=(chromium)
bench=(
  libbenchmark-dev     # Google Benchmark
  libtinyobjloader-dev # peer of the OBJ reader
  libocct-modeling-algorithms-dev libocct-visualization-dev # peer of the mesher; the second has a header that the first needs
  libtbb-dev           # libtbb.so, which OpenCASCADE's CMake targets name and its packages do not ask for
)

case "${1:-}" in
  "")        want=("${build[@]}" "${tests[@]}") ;;
  --minimal) want=("${build[@]}") if_there=() ;;
  --bench)   want=("${build[@]}" "${tests[@]}" "${bench[@]}") ;;
  -h|--help) sed -n '2,6s/^# //p' "$0"; exit 0 ;;
  *)         echo "setup: unknown option '$1' (setup.sh --help)" >&2; exit 1 ;;
esac

installed() { [ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null || true)" = installed ]; }
missing=() missing_if_there=()
for package in "${want[@]}"; do
  installed "$package" || missing+=("$package")
done
for package in "${if_there[@]}"; do
  installed "$package" || missing_if_there+=("$package")
done
if [ ${#missing[@]} -eq 0 ] && [ ${#missing_if_there[@]} -eq 0 ]; then
  echo "setup: all ${#want[@]} packages are installed"
  exit 0
fi

as_root=()
if [ "$(id -u)" -ne 0 ]; then
  command -v sudo >/dev/null || { echo "setup: needs root or sudo to install: ${missing[*]} ${missing_if_there[*]}" >&2; exit 1; }
  as_root=(sudo)
fi
all_missing=("${missing[@]}" "${missing_if_there[@]}")
echo "setup: installing ${all_missing[*]}"
# `env` carries the setting through sudo.
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q -o DPkg::Lock::Timeout=300)
log=$(mktemp)
trap 'rm -f "$log"' EXIT
install() { [ $# -eq 0 ] || "${apt[@]}" install -y --no-install-recommends "$@"; }
if ! { "${apt[@]}" update && install "${missing[@]}"; } >"$log" 2>&1; then
  tail -n 30 "$log" >&2
  echo "setup: apt-get failed (its last lines are above)" >&2
  exit 1
fi
install "${missing_if_there[@]}" >"$log" 2>&1 || echo "setup: going on without ${missing_if_there[*]}, which could not be installed"
echo "setup: done"
