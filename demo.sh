#!/usr/bin/env bash
# Runs the main jobs on the built-in phantoms: installs packages, builds trephine, touches and drills a skull,
# performs a guided craniotomy from its first step to its score, and opens the simulator if there is a display.
# Writes to out/: pictures, report.json, the session of the craniotomy and its report.html.
# With arguments, installs and builds, then runs only `trephine demo` with these arguments, for example:
# ./demo.sh path/to/a/DICOM/folder
set -euo pipefail
cd "$(dirname "$0")"
. cmake/setup.sh
install_packages $packages_core $packages_files $packages_app
install_viewer_packages
build_preset release "trephine trephine_window trephine_pictures trephine_vdb trephine_tables" -DTREPHINE_WITH_TESTS=OFF
trephine=build/release/bin/trephine
[ $# -eq 0 ] || exec $trephine demo "$@"
$trephine demo --no-window
echo "performing a guided craniotomy, step by step"
rm -f out/craniotomy.session out/report.html
$trephine run docs/examples/procedure-craniotomy.toml --record out/craniotomy.session
$trephine report out/craniotomy.session -o out/report.html
[ -n "${DISPLAY:-}" ] || exit 0
# Exit code 3: the display does not answer. The pictures and the report are written.
$trephine simulator || [ $? -eq 3 ]
