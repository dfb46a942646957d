#!/usr/bin/env bash
# install_test.sh BUILD SOURCE: installs into a scratch prefix, builds an external project and a module against the
# installation, and runs them. Then moves the installation, runs it again, and tests the completion of the command
# line. If TREPHINE_WHOLE is set, each installed header is compiled alone.
set -euo pipefail
build=$1 source=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >/dev/null
cmake -S "$source/tests/package/outside" -B "$scratch/outside" -DCMAKE_PREFIX_PATH="$scratch/prefix" -DTREPHINE_EXAMPLES="$source/docs/examples" ${TREPHINE_WHOLE:+-DHEADERS_ALONE=ON} >"$scratch/log" 2>&1 ||
  { cat "$scratch/log"; exit 1; }
cmake --build "$scratch/outside" -j 2 >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
env -u LD_LIBRARY_PATH "$scratch/outside/outside"
env -u LD_LIBRARY_PATH "$scratch/outside/drill" | tail -1
env -u LD_LIBRARY_PATH "$scratch/outside/drill_head" >"$scratch/log"
grep -E ': +[0-9.]*[1-9][0-9.]* N, +[0-9.]*[1-9][0-9.]* mm3 removed' "$scratch/log" ||
  { echo "drill_head does not print a force and removed bone:"; cat "$scratch/log"; exit 1; }
# A module that is a project of its own builds against the installation, and the installed program loads it.
cmake -S "$source/docs/examples/eraser" -B "$scratch/eraser" -DCMAKE_PREFIX_PATH="$scratch/prefix" >"$scratch/log" 2>&1 &&
  cmake --build "$scratch/eraser" >"$scratch/log" 2>&1 || { cat "$scratch/log"; exit 1; }
"$scratch/prefix/bin/trephine" modules eraser --module "$scratch/eraser/liberaser.so" | grep -q 'instrument eraser' ||
  { echo "the installed program does not load the eraser"; exit 1; }
(cd "$scratch" && "$scratch/prefix/bin/trephine" run "$source/docs/examples/eraser/eraser.toml" --module "$scratch/eraser/liberaser.so" >"$scratch/log" 2>&1) ||
  { echo "the installed program does not run the eraser's script:"; cat "$scratch/log"; exit 1; }
for file in bin/trephine share/man/man1/trephine.1.gz share/man/man1/trephine-drill.1.gz lib/udev/rules.d/60-trephine.rules \
  share/bash-completion/completions/trephine; do
  [ -s "$scratch/prefix/$file" ] || { echo "missing: $file"; exit 1; }
done
# The moved installation still runs: the program finds its libraries by a relative path.
mv "$scratch/prefix" "$scratch/elsewhere"
cd "$scratch"
"$scratch/elsewhere/bin/trephine" phantom sphere --size 16 -o s.mha >/dev/null
"$scratch/elsewhere/bin/trephine" info s.mha --json | grep -q '"trephine.info/1"'
# The servo core links neither VTK nor OpenVDB nor Qt nor TBB nor ITK.
library=$(find "$scratch/elsewhere" -name 'libtrephine-haptics.so.0.1')
if ldd "$library" | grep -Ei 'vtk|openvdb|qt5|tbb|itk'; then echo "the servo's library links an unneeded library"; exit 1; fi
# Completion of the command line.
. "$scratch/elsewhere/share/bash-completion/completions/trephine"
COMP_WORDS=(trephine dr) COMP_CWORD=1
_trephine
[ "${COMPREPLY[*]}" = drill ] || { echo "completion of 'dr' is '${COMPREPLY[*]}'"; exit 1; }
COMP_WORDS=(trephine drill --kin) COMP_CWORD=2
_trephine
[ "${COMPREPLY[*]}" = --kinematic ] || { echo "completion of '--kin' is '${COMPREPLY[*]}'"; exit 1; }
echo "installation, external projects, moved installation and completion work"
