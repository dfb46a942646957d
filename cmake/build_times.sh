#!/usr/bin/env bash
# cmake/build_times.sh [BUILD]: prints build times in s: the sum for each folder, and the ten longest steps. The last
# build of each output counts. BUILD is build/release by default. An output in the cache of ccache takes almost no
# time.
set -euo pipefail
cd "$(dirname "$0")/.."
log=${1:-build/release}/.ninja_log
[ -f "$log" ] || { echo "error: $log is missing. Build first: cmake --build ${1:-build/release}" >&2; exit 1; }
awk -F'\t' 'NR > 1 { last[$4] = $2 - $1 } END { for (name in last) print last[name] / 1000 "\t" name }' "$log" |
  sort -rn | awk -F'\t' '
    NR <= 10 { longest[NR] = sprintf("%8.1f  %s", $1, $2) }
    {
      count = split($2, part, "/")
      folder = count == 1 ? "." : part[1]
      if (part[1] == "tests" && match($2, /_tests?\.dir/)) folder = "tests"
      else if (part[1] == "apps" && count > 2) folder = part[1] "/" part[2]
      sum[folder] += $1; all += $1
    }
    END {
      for (name in sum) printf "%8.1f  %s\n", sum[name], name | "sort -rn"
      close("sort -rn")
      printf "%8.1f  in all\n\nlongest steps\n", all
      for (i = 1; i <= 10; ++i) print longest[i]
    }'
