#!/usr/bin/env bash
# deb_test.sh BUILD: makes the .deb packages, checks their dependencies, installs them with dpkg into a scratch root
# and runs the command there.
set -euo pipefail
build=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
(cd "$build" && cpack -G DEB -B "$scratch/deb" >"$scratch/log" 2>&1) || { cat "$scratch/log"; exit 1; }
cd "$scratch"
field() { dpkg-deb -f "$1" "$2"; }
for name in libtrephine0.1 libtrephine-dev trephine trephine-window trephine-formats python3-trephine; do
  ls deb/"$name"_*.deb >/dev/null 2>&1 || { echo "the package $name is missing"; exit 1; }
done
library=$(field deb/libtrephine0.1_*.deb Depends) command=$(field deb/trephine_*.deb Depends)
window=$(field deb/trephine-window_*.deb Depends) dev=$(field deb/libtrephine-dev_*.deb Depends)
refuse() { if echo "$2" | grep -qiE "$3"; then echo "the package $1 has an unneeded dependency ($3): $2"; exit 1; fi; }
demand() { echo "$2" | grep -qE "$3" || { echo "the package $1 lacks the dependency $3: $2"; exit 1; }; }
refuse library "$library" 'vtk|itk|qt|openvdb|tbb'
refuse command "$command" 'qt5|openimageio|openvdb|hdf5'
demand formats "$(field deb/trephine-formats_*.deb Depends)" 'libopenimageio'
demand formats "$(field deb/trephine-formats_*.deb Depends)" 'libhdf5'
demand library "$library" 'libc6'
demand command "$command" 'libtrephine0.1 \(= 0.1.0\)'
demand command "$command" 'libvtk9.1'
demand python "$(field deb/python3-trephine_*.deb Depends)" 'python3-numpy'
refuse python "$(field deb/python3-trephine_*.deb Depends)" 'qt5'
demand window "$window" 'libqt5widgets5'
demand window "$window" 'trephine \(= 0.1.0\)'
demand dev "$dev" 'libtrephine0.1 \(= 0.1.0\)'
demand dev "$dev" 'libglm-dev'
# Installs into a scratch root. The packages on which they depend are those of the machine.
mkdir -p system/var/lib/dpkg/{info,updates} system/var/lib/dpkg/triggers
touch system/var/lib/dpkg/{status,available}
dpkg --root="$scratch/system" --force-not-root --force-depends --force-script-chrootless --log=/dev/null -i deb/*.deb >log 2>&1 ||
  { cat log; exit 1; }
export LD_LIBRARY_PATH=$scratch/system/usr/lib/$(dpkg-architecture -qDEB_HOST_MULTIARCH):$scratch/system/usr/lib
system/usr/bin/trephine phantom sphere --size 24 -o s.mha >/dev/null
system/usr/bin/trephine info s.mha | grep -q MetaImage
system/usr/bin/trephine convert s.mha -o s.vdb >/dev/null && system/usr/bin/trephine info s.vdb | grep -q OpenVDB
env -u DISPLAY system/usr/bin/trephine view s.mha --iso 300 --screenshot s.png >/dev/null
[ -s s.png ]
[ -s system/usr/share/applications/trephine.desktop ] && [ -s system/usr/share/icons/hicolor/scalable/apps/trephine.svg ]
[ -s system/usr/lib/udev/rules.d/60-trephine.rules ]
# Runs the Python module, and the program for cohorts.
env -u LD_LIBRARY_PATH PYTHONPATH=system/usr/lib/python3/dist-packages /usr/bin/python3 -c "
import trephine
operation = trephine.Operation.open(trephine.Scan.phantom('sphere', spacing=(2, 2, 2)), iso=300)
assert operation.run([[0, 0, 60], [0, 0, 20]]).contact.any()"
{ system/usr/bin/trephine-cohort plan none.toml -o plan.csv 2>&1 || true; } | grep -q 'does not exist'
[ -s system/usr/share/trephine/cohort/Snakefile ]
# If xvfb-run is installed, the window's package is also tested.
if command -v xvfb-run >/dev/null; then
  XDG_STATE_HOME=$scratch/state xvfb-run -a -s '-screen 0 1024x768x24' system/usr/bin/trephine view s.mha --iso 300 --seconds 1 --json >view.json
  grep -q '"window": "qt"' view.json || { echo "the window's package was not used"; cat view.json; exit 1; }
fi
echo "packages: $(ls deb | tr '\n' ' ')"
