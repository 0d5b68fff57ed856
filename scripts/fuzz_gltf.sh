#!/usr/bin/env bash
# Fuzzes the glTF reader and the Draco decoder under the address and undefined behaviour sanitizers, from files of our own writer.
# usage: scripts/fuzz_gltf.sh [SECONDS each, default 600] [FOLDER, default build/fuzz]
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."
seconds=${1:-600}
folder=${2:-build/fuzz}
mkdir -p "$folder/seeds" "$folder/gltf" "$folder/draco"
flags=(-std=c++20 -O1 -g1 -fno-omit-frame-pointer -fsanitize=address,undefined,fuzzer-no-link -fno-sanitize-recover=all
       -I. -isystem /usr/include/eigen3)
# Only what the readers need, so that the run starts within minutes.
sources=(core/result.cpp core/diagnostics.cpp core/parallel.cpp core/counted.cpp formats/byte_sink.cpp formats/float_rows.cpp formats/text_number.cpp formats/written_mesh.cpp
         formats/element_runs.cpp formats/gltf*.cpp formats/glb*.cpp formats/draco*.cpp)
objects=()
for source in "${sources[@]}" tests/fuzz/gltf_fuzz.cpp tests/fuzz/gltf_draco_fuzz.cpp tests/formats/gltf_samples.cpp; do
  object="$folder/$(echo "$source" | tr / _).o"
  if [ ! -e "$object" ] || [ -n "$(find "$source" formats core tests/fuzz tests/support -newer "$object" -name '*.h' -print -quit)" ] ||
     [ "$source" -nt "$object" ]; then
    echo "fuzz: compiling $source"
    clang++ "${flags[@]}" -c "$source" -o "$object"
  fi
  case "$source" in tests/*) ;; *) objects+=("$object") ;; esac
done
link=(clang++ -fsanitize=address,undefined)
"${link[@]}" "$folder/tests_formats_gltf_samples.cpp.o" "${objects[@]}" -ldraco -lmeshoptimizer -lhwy -lpthread -o "$folder/samples"
for target in gltf gltf_draco; do
  "${link[@]}" -fsanitize=fuzzer "$folder/tests_fuzz_${target}_fuzz.cpp.o" "${objects[@]}" -ldraco -lmeshoptimizer -lhwy -lpthread -o "$folder/${target}_fuzz"
done
"$folder/samples" "$folder/seeds"
rm -f "$folder"/seeds/*large*
"$folder/gltf_fuzz" -max_total_time="$seconds" -max_len=16384 -rss_limit_mb=2048 -timeout=10 -dict=tests/fuzz/gltf.dict \
  -print_final_stats=1 "$folder/gltf" "$folder/seeds" fixtures/meshes/gltf 2>&1 | tail -n 15
"$folder/gltf_draco_fuzz" -max_total_time="$seconds" -max_len=8192 -rss_limit_mb=2048 -timeout=10 \
  -print_final_stats=1 "$folder/draco" fixtures/meshes/gltf_draco 2>&1 | tail -n 15
