#!/usr/bin/env bash
# Tessellates random part programs and proves every mesh; tells what fails and keeps the programs.
# usage: scripts/soak_tessellation.sh [FIRST [COUNT [FOLDER]]]   (default: 1 1000 build/soak)
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."
case "${1:-}" in -h|--help) sed -n '2,3s/^# //p' "$0"; exit 0 ;; esac
first=${1:-1} count=${2:-1000} folder=${3:-build/soak}
[ -f build/release/CMakeCache.txt ] || cmake --preset release >/dev/null
cmake --build build/release --target tessellation_soak
mkdir -p "$folder"
# As many lanes as there are cores, each with its share of the seeds.
lanes=$(nproc) pids=() status=0
for ((lane = 0; lane < lanes; ++lane)); do
  from=$((first + count * lane / lanes)) to=$((first + count * (lane + 1) / lanes))
  [ "$to" -gt "$from" ] || continue
  build/release/bin/tessellation_soak "$from" "$((to - from))" "$folder" &
  pids+=($!)
done
for pid in "${pids[@]}"; do wait "$pid" || status=1; done
exit $status
