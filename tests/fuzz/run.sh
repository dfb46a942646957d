#!/usr/bin/env bash
# run.sh BUILD SECONDS: runs each fuzzer for SECONDS, starting with the corpora of this folder; fails at the first
# finding.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
build=$1 seconds=$2
for target in session path case plan dicom volume_file device; do
  mkdir -p "$build/corpus/$target"
  options=""
  # ITK's readers leak memory of invalid headers; these leaks are ignored.
  case $target in dicom | volume_file) options=detect_leaks=0 ;; esac
  echo "fuzzing $target for $seconds s"
  ASAN_OPTIONS=$options "$build/bin/fuzz_$target" -timeout=20 -max_total_time="$seconds" -rss_limit_mb=4000 -artifact_prefix="$build/" \
    "$build/corpus/$target" "$here/corpus/$target" >"$build/$target.log" 2>&1 || { tail -40 "$build/$target.log"; exit 1; }
  tail -1 "$build/$target.log"
done
