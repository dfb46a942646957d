#!/usr/bin/env bash
# ./test.sh              builds the release preset and runs the quick suites
# ./test.sh NAME         only tests whose name matches NAME
# ./test.sh --all [P]    also core, debug, asan, tsan and clang, or only preset P of these
set -euo pipefail
cd "$(dirname "$0")"
. cmake/setup.sh

# Scratch files of the tests stay in the clone too.
export TMPDIR="$PWD/build/tmp"
mkdir -p "$TMPDIR"

run_tests() { # PRESET [CTEST OPTIONS ...]
  local preset=$1
  shift
  echo "== $preset"
  ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" "$@"
}

if [ "${1:-}" = --all ]; then
  install_packages $packages_core $packages_files $packages_app $packages_test $packages_all
  for preset in ${2:-core debug asan tsan clang release}; do
    build_preset "$preset" all -DTREPHINE_WITH_TESTS=ON
    if [ "$preset" = release ] || [ "$preset" = debug ]; then run_tests "$preset"; else run_tests "$preset" -E "^Golden"; fi
  done
  exit
fi
install_packages $packages_core $packages_files $packages_app $packages_test
build_preset release all -DTREPHINE_WITH_TESTS=ON
run_tests release ${1:+-R "$1"}
