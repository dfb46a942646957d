#!/usr/bin/env bash
# check.sh module|examples|types FOLDER: tests the Python module in FOLDER, runs the examples with it, or
# checks the types of the examples.
set -euo pipefail
source=$(cd "$(dirname "$0")/../.." && pwd)
export PYTHONPATH=$2 PYTHONDONTWRITEBYTECODE=1 TREPHINE_COMMAND=$2/../bin/trephine
python=/usr/bin/python3
case $1 in
  module) $python -m pytest -q -p no:cacheprovider "$source/tests/python" ;;
  examples)
    for example in "$source"/docs/examples/python/*.py; do
      echo "== $(basename "$example")"
      $python "$example"
    done
    ;;
  types)
    cache=$(mktemp -d)
    trap 'rm -rf "$cache"' EXIT
    for example in "$source"/docs/examples/python/*.py; do
      MYPYPATH=$2 mypy --strict --cache-dir "$cache" "$example"
    done
    ;;
esac
