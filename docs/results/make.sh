#!/bin/sh
# Runs the short benchmarks and writes their tables to this folder, one page each. Use an idle machine.
# Usage: docs/results/make.sh [NAME ...]     (without a name: all benchmarks)
set -eu
cd "$(dirname "$0")/../.."
bench=build/release/bin/trephine-bench
charts=$(mktemp -d)
trap 'rm -rf "$charts"' EXIT
machine="$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1), $(nproc) cores"

# Writes one page: NAME, title, options of the benchmark.
page() {
  name=$1 title=$2
  shift 2
  case " ${names:-$name} " in *" $name "*) ;; *) return 0 ;; esac
  echo "$name ..."
  # The printed command has the folder `out` in place of the temporary folder of charts.
  shown=$(echo "$name $*" | sed "s|-o $charts|-o out|")
  table=$("$bench" "$name" "$@" 2>/dev/null | grep -v "$charts") || { echo "failed: $name" >&2; exit 1; }
  cat > "docs/results/$name.md" <<END
# $title

    trephine-bench $shown

$("$bench" --version | head -1 | sed 's/ (.*//'), $machine, $(date +%Y-%m-%d).

\`\`\`text
$table
\`\`\`
END
}

names=$*
page feel "Contact methods and other libraries" --quick -o "$charts"
page stability "Random attacks and energy" --steps 300000 -o "$charts"
page depth "Contact by depth images" --quick
page drill "Drilling" --quick
page step "Steps and updates" --size 256
page pedicle "Pedicle screws and the probe" --quick
page whole-tool "Whole tools" --quick
page rays "Rays through voxels" --size 256
page surface "Surface extraction" --size 256
page flood "Floods and components" --size 256
page separation "Detection of disconnected parts"
page xray "X-ray images" --quick --size 256
page reslice "Slices" --size 256
page render "Volume rendering" --size 256
