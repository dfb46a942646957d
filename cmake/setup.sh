# Functions for demo.sh and test.sh: install missing Debian packages and the npm packages of the viewer, configure
# and build. Must be sourced from the top of the clone. Outside the clone, only Debian packages and the caches of apt
# and npm are written.

packages_core="cmake g++ git ca-certificates ninja-build ccache mold libglm-dev libzstd-dev"
packages_files="libopenimageio-dev libopenvdb-dev libtbb-dev libhdf5-dev nlohmann-json3-dev libinsighttoolkit5-dev libvtk9-dev libarchive-dev libgdcm-dev libnifti-dev libteem-dev zlib1g-dev libtoml11-dev"
packages_app="libcli11-dev nlohmann-json3-dev libegl-dev libegl1 libgl1-mesa-dri libvtk9-qt-dev qtbase5-dev qtmultimedia5-dev qttools5-dev libopenxr-dev pkgconf libusb-1.0-0-dev libhidapi-dev"
packages_test="clang-format libgtest-dev umockdev xvfb xauth xz-utils python3-h5py pybind11-dev python3-dev python3-numpy python3-pytest mypy"
packages_all="clang libclang-rt-14-dev dpkg-dev libembree-dev libnanovdb-dev libfcl-dev dcmtk python3-nibabel python3-pydicom"

# install_packages NAME ...: installs missing packages, after printing names and sizes.
install_packages() {
  local missing=() name sudo=""
  for name in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$name" 2>/dev/null)" = installed ] || missing+=("$name")
  done
  [ ${#missing[@]} -gt 0 ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    command -v sudo >/dev/null || { echo "error: packages are missing, and there is no sudo. As root, run: apt-get install ${missing[*]}" >&2; return 3; }
    sudo=sudo
  fi
  echo "installing ${#missing[@]} missing Debian packages: ${missing[*]}"
  $sudo apt-get update -qq || { echo "error: the package lists cannot be fetched. Check the network." >&2; return 3; }
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install --assume-no --no-install-recommends "${missing[@]}" 2>/dev/null |
    grep -E '^(Need to get|After this operation|[0-9]+ upgraded)' || true
  $sudo env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends -o Dpkg::Use-Pty=0 "${missing[@]}" >/dev/null ||
    { echo "error: packages could not be installed. For the reason, run: ${sudo:+sudo }apt-get install ${missing[*]}" >&2; return 3; }
}

# install_viewer_packages: installs the npm packages of the reports' 3-D viewer into build/report-viewer, in the
# versions of the lock file. Without npm or a network, reports contain pictures but no 3-D viewer.
install_viewer_packages() {
  local folder="$PWD/build/report-viewer" source="$PWD/apps/cli/report"
  cmp -s "$source/package-lock.json" "$folder/installed-lock.json" && return 0
  command -v npm >/dev/null || { echo "note: no npm; report pages are built without the 3-D viewer"; return 0; }
  mkdir -p "$folder"
  cp "$source/package.json" "$source/package-lock.json" "$folder/"
  if (cd "$folder" && timeout 300 npm ci --ignore-scripts --no-audit --no-fund --loglevel=error >/dev/null 2>&1); then
    cp "$source/package-lock.json" "$folder/installed-lock.json"
  else
    rm -rf "$folder/node_modules"
    echo "note: the npm packages could not be installed; report pages are built without the 3-D viewer"
  fi
}

# build_preset PRESET ["TARGETS"] [CMAKE OPTIONS ...]: configures and builds into build/PRESET. The output of the
# configuration is shown only if it fails.
build_preset() {
  local preset=$1 target=${2:-all}
  shift $(($# > 1 ? 2 : 1))
  export CCACHE_DIR="$PWD/.ccache"
  mkdir -p build
  local log="build/configure-$preset.log"
  cmake --preset "$preset" "$@" >"$log" 2>&1 || { cat "$log" >&2; return 1; }
  cmake --build "build/$preset" --target $target
}
