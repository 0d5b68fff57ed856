#!/usr/bin/env bash
# Installs what the tests need, builds everything, runs every test; ends with the counts and, where one failed, not with 0.
# usage: scripts/test.sh [ctest options, e.g. -R formats]
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."

scripts/setup.sh
echo "test: npm ci in tests/formats/npm (independent glTF readers)"
(cd tests/formats/npm && npm ci --silent --no-audit --no-fund) ||
  echo "test: npm could not install them; tests that need them say that they are skipped"
echo "test: building"
mkdir -p build
cmake --preset release -DDIESINK_BUILD_TESTS=ON -DDIESINK_BUILD_BENCH=OFF -DCMAKE_VERIFY_INTERFACE_HEADER_SETS=ON >build/test-configure.log 2>&1 ||
  { tail -n 40 build/test-configure.log >&2; exit 1; }
# Every public header must compile on its own, too.
cmake --build --preset release --target all all_verify_interface_header_sets
echo "test: running"
ctest --preset release -j "$(nproc)" "$@"
