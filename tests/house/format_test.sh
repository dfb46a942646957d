#!/usr/bin/env bash
# format_test.sh SOURCE: C++ sources are formatted as .clang-format states. To repair: clang-format -i FILE ...
set -euo pipefail
cd "$1"
command -v clang-format >/dev/null || { echo "clang-format is missing: apt-get install clang-format"; exit 77; }
folders="volume haptics sim modules data-tools apps tests docs/examples"
find $folders -name '*.h' -o -name '*.cpp' -o -name '*.c' | xargs -n 40 -P 2 clang-format --dry-run -Werror
# A planted fault is found.
if echo 'int  a;' | clang-format --dry-run -Werror 2>/dev/null; then echo "clang-format does not report the planted fault"; exit 1; fi
