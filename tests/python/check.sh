#!/usr/bin/env bash
# check.sh module|examples|types FOLDER: tests the Python module in FOLDER, runs the examples with it, or
# checks the types of the examples. Longer tests and examples run only with TREPHINE_WHOLE.
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)
export PYTHONPATH=$2 PYTHONDONTWRITEBYTECODE=1 TREPHINE_COMMAND=$2/../bin/trephine
python=/usr/bin/python3
case $1 in
  module) $python -m pytest -q -p no:cacheprovider "$source/tests/python" ;;
  examples)
    for example in "$source"/docs/examples/python/*.py; do
      case $(basename "$example") in
        compare_methods.py | screw_sweep.py) [[ -n ${TREPHINE_WHOLE:-} ]] || continue ;;  # 13 and 10 s
      esac
      echo "== $(basename "$example")"
      $python "$example"
    done
    ;;
  types)
    cache=$(mktemp -d)
    trap 'rm -rf "$cache"' EXIT
    # Checks the module, too: mypy reports no errors of packages that are found by PYTHONPATH.
    unset PYTHONPATH
    MYPYPATH=$2 mypy --strict --scripts-are-modules --cache-dir "$cache" "$source"/docs/examples/python/*.py
    ;;
esac
