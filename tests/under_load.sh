#!/usr/bin/env bash
# under_load.sh [BUILD] [RUNS] [LOOPS]: runs all tests RUNS times (3) while LOOPS busy loops (4) occupy the CPUs.
# Stops after the first run with a failed test.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:-build/release} runs=${2:-3} loops=${3:-4}
export TMPDIR="$PWD/build/tmp"
mkdir -p "$TMPDIR"
busy=()
trap 'kill "${busy[@]}" 2>/dev/null' EXIT
for _ in $(seq "$loops"); do
  while :; do :; done &
  busy+=($!)
done
for run in $(seq "$runs"); do
  echo "== run $run of $runs, $loops busy loops"
  ctest --test-dir "$build" --no-tests=error -j "$(nproc)" --output-on-failure | tail -n 12
done
