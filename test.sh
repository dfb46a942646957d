#!/usr/bin/env bash
# ./test.sh              builds the release preset and runs the quick suites
# ./test.sh NAME         only tests whose name matches NAME
# ./test.sh --all [P]    runs all cases of long tests in the presets core, debug, asan, tsan, clang and release,
#                        and the parts fuzz, package, cohort (on Slurm) and soak; or only the preset or part P
#                        (TREPHINE_FUZZ_SECONDS per fuzzer, TREPHINE_SOAK_SECONDS, TREPHINE_ATTACK_STEPS, TREPHINE_KILLS)
set -euo pipefail
cd "$(dirname "$0")"
. cmake/setup.sh

# Scratch files of the tests stay in the clone.
export TMPDIR="$PWD/build/tmp"
mkdir -p "$TMPDIR"

run_tests() { # PRESET [CTEST OPTIONS ...]
  local preset=$1
  shift
  echo "== $preset"
  # The number of skipped tests is printed before the closing lines of ctest.
  ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" "$@" | awk '
    /^[0-9]+% tests passed/ { closing = 1 }
    !closing { print; fflush(); next }
    { lines[++count] = $0; skipped += /\(Skipped\)/ }
    END {
      print "tests skipped without real data (TREPHINE_DATA), AVX2 or Xvfb: " skipped + 0
      for (i = 1; i <= count; ++i) print lines[i]
    }'
}

if [ "${1:-}" = --all ]; then
  install_packages $packages_core $packages_files $packages_app $packages_test $packages_all
  install_viewer_packages
  export TREPHINE_KILLS=${TREPHINE_KILLS:-200} TREPHINE_WHOLE=1
  for preset in ${2:-core debug asan tsan clang fuzz release package cohort soak}; do
    case $preset in
      fuzz)
        echo "== fuzz"
        build_preset fuzz all -DTREPHINE_WITH_TESTS=OFF
        tests/fuzz/run.sh build/fuzz "${TREPHINE_FUZZ_SECONDS:-60}"
        continue
        ;;
      package)
        echo "== package"
        build_preset release all -DTREPHINE_WITH_TESTS=ON -DTREPHINE_WITH_PYTHON=ON
        tests/package/deb_test.sh build/release
        continue
        ;;
      cohort)
        echo "== cohort"
        install_packages slurm-wlm munge snakemake
        build_preset release trephine
        tests/python/cohort_on_slurm.sh build/release/bin/trephine
        continue
        ;;
      soak)
        echo "== soak"
        build_preset release trephine_bench_program
        XDG_STATE_HOME=$TMPDIR build/release/bin/trephine-bench soak --seconds "${TREPHINE_SOAK_SECONDS:-60}"
        build/release/bin/trephine-bench stability --steps "${TREPHINE_ATTACK_STEPS:-3000000}"
        continue
        ;;
    esac
    build_preset "$preset" all -DTREPHINE_WITH_TESTS=ON $([ "$preset" != release ] || echo -DTREPHINE_WITH_PYTHON=ON)
    if [ "$preset" = release ] || [ "$preset" = debug ]; then run_tests "$preset"; else run_tests "$preset" -E "^Golden"; fi
  done
  exit
fi
install_packages $packages_core $packages_files $packages_app $packages_test
install_viewer_packages
build_preset release all -DTREPHINE_WITH_TESTS=ON -DTREPHINE_WITH_PYTHON=ON
run_tests release ${1:+-R "$1"}
