#!/usr/bin/env bash
# Builds the benchmarks, runs them and prints one table: what, time of one run, the processor's time in its
# main thread (all of it in runs of one thread; the figure to compare on a busy machine), and its rate.
# usage: scripts/bench.sh [--filter REGEX] [--seconds S] [--repeat N] [--json FILE] [--page FILE]
#   --filter   only benchmarks whose name matches; without it those that take minutes (solids/6400) are left out
#   --seconds  least time of each (default 0.5)
#   --repeat   the fastest of so many is told (default 3): other work on the machine only ever slows one down
#   --json     keep Google Benchmark's own figures as well, one object a program
#   --page     put the table into a page as well, between <!-- bench --> and <!-- end -->: docs/benchmarks.md
# SPDX-License-Identifier: Apache-2.0
set -euo pipefail
cd "$(dirname "$0")/.."

filter= seconds=0.5 repeat=3 json= page=
while [ $# -gt 0 ]; do
  case "$1" in
    --filter|--seconds|--repeat|--json|--page)
      [ $# -gt 1 ] || { echo "bench: $1 needs a value" >&2; exit 1; }
      declare "${1#--}=$2"
      shift 2 ;;
    -h|--help) sed -n '2,9s/^# //p' "$0"; exit 0 ;;
    *) echo "bench: unknown option '$1' (bench.sh --help)" >&2; exit 1 ;;
  esac
done

scripts/setup.sh --bench
mkdir -p build
cmake --preset release -DDIESINK_BUILD_BENCH=ON >build/bench-configure.log 2>&1 ||
  { tail -n 40 build/bench-configure.log >&2; exit 1; }
cmake --build --preset release --target benches

results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
for program in build/release/bin/*_bench; do
  name=$(basename "$program")
  echo "bench: $name" >&2
  chosen=$("$program" --benchmark_list_tests | grep -E -- "${filter:-.}" || true)
  [ -n "$filter" ] || chosen=$(grep -v '/6400/' <<<"$chosen" || true)
  [ -n "$chosen" ] || continue
  "$program" --benchmark_filter="^($(tr '\n' '|' <<<"$chosen" | sed 's/|$//; s/[.+*?()]/\\&/g'))\$" --benchmark_min_time="$seconds" \
    --benchmark_repetitions="$repeat" \
    --benchmark_out="$results/$name.json" --benchmark_out_format=json >/dev/null 2>"$results/$name.log" ||
    { cat "$results/$name.log" >&2; exit 1; }
done

PYTHONPATH=scripts python3 - "$results" "$json" "$page" <<'PYTHON'
import json
import os
import sys

import page_table

folder, keep, page = sys.argv[1:4]
TIMES = [("s", 1), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)]
UNITS = {"ns": 1e-9, "us": 1e-6, "ms": 1e-3, "s": 1.0}


def scaled(value, units):
    for unit, size in units:
        if value >= size:
            return f"{value / size:.3g} {unit}"
    return f"{value:.3g}"


rows, all_figures, machine = [], {}, None
for file in sorted(os.listdir(folder)):
    path = os.path.join(folder, file)
    if not file.endswith(".json") or os.path.getsize(path) == 0:
        continue
    with open(path) as stream:
        figures = json.load(stream)
    name = file[: -len(".json")]
    all_figures[name] = figures
    machine = figures["context"]
    fastest = {}
    for b in figures["benchmarks"]:
        if b.get("run_type") == "aggregate" or b.get("error_occurred"):
            continue
        if b["name"] not in fastest or b["real_time"] < fastest[b["name"]]["real_time"]:
            fastest[b["name"]] = b
    for b in fastest.values():
        seconds = b["real_time"] * UNITS[b["time_unit"]]
        time = scaled(seconds, TIMES)
        processor = scaled(b["cpu_time"] * UNITS[b["time_unit"]], TIMES)
        rate = ""
        if "items_per_second" in b:
            rate = scaled(b["items_per_second"], [("G/s", 1e9), ("M/s", 1e6), ("k/s", 1e3), ("/s", 1)])
        elif "bytes_per_second" in b:
            rate = scaled(b["bytes_per_second"], [("GB/s", 1e9), ("MB/s", 1e6), ("kB/s", 1e3), ("B/s", 1)])
        if "times_mesh" in b:
            rate = f"{b['times_mesh']:.2f} x mesh"
        rows.append((name.removesuffix("_bench"), b["name"].removesuffix("/real_time"), time, processor, rate))
if keep:
    with open(keep, "w") as stream:
        json.dump(all_figures, stream, indent=1)
        stream.write("\n")
if not rows:
    raise SystemExit("bench: no benchmark has such a name")
about = f"{machine['num_cpus']} cores at {machine['mhz_per_cpu']} MHz, load {machine['load_avg'][0]:.2f}"
print(about)
rows.insert(0, ("stage", "benchmark", "time", "processor", "rate"))
if page:
    page_table.replace(page, "bench", f"{about}, {machine['date'][:10]}\n\n" + page_table.markdown([(f"{r[0]}: {r[1]}", *r[2:]) for r in rows]))
widths = [max(len(row[k]) for row in rows) for k in range(5)]
for row in rows:
    print(f"{row[0]:<{widths[0]}}  {row[1]:<{widths[1]}}  {row[2]:>{widths[2]}}  {row[3]:>{widths[3]}}  {row[4]:>{widths[4]}}")
PYTHON
