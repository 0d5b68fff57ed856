#!/bin/sh
# Fuzzes the readers under the address and undefined behaviour sanitizers: scripts/fuzz.sh [SECONDS each] [READER...].
# Needs clang. New inputs go to build/fuzz/corpus, findings to build/fuzz; a finding that is mended goes to
# fixtures/meshes/READER, where the tests replay it.
set -eu
cd "$(dirname "$0")/.."
seconds=${1:-600}
[ $# -gt 0 ] && shift
cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_COMPILER=clang++ -DDIESINK_BUILD_BENCH=OFF \
  -DDIESINK_BUILD_FUZZERS=ON \
  "-DCMAKE_CXX_FLAGS=-O1 -g -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all" \
  > /dev/null
readers=${*:-stl obj ply off}
for reader in $readers; do ninja -C build/fuzz "fuzz_$reader"; done
for reader in $readers; do
  mkdir -p "build/fuzz/corpus/$reader"
  "build/fuzz/bin/fuzz_$reader" -dict=tests/fuzz/mesh.dict -max_total_time="$seconds" -timeout=10 -rss_limit_mb=2048 \
    -max_len=4096 -artifact_prefix="build/fuzz/$reader-" "build/fuzz/corpus/$reader" "fixtures/meshes/$reader"
done
