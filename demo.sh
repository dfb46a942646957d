#!/usr/bin/env bash
# The main job on the built-in phantom: installs and builds what it needs, then touches, drills and shows a skull.
# Always leaves three pictures and report.json in out/; opens a window too where there is a display.
# Any arguments go to `trephine demo`, for example: ./demo.sh path/to/a/DICOM/folder
set -euo pipefail
cd "$(dirname "$0")"
. cmake/setup.sh
install_packages $packages_core $packages_files $packages_app
install_viewer_packages
build_preset release "trephine trephine_window trephine_pictures trephine_vdb trephine_tables" -DTREPHINE_WITH_TESTS=OFF
exec build/release/bin/trephine demo "$@"
