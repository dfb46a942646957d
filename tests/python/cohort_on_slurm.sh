#!/usr/bin/env bash
# cohort_on_slurm.sh COMMAND: runs 200 cases on Slurm on this machine, and kills Snakemake, slurmd and running cases
# in between. The table must equal that of an undisturbed run. One case has a broken scan: its row contains the
# error. Requires root, and the packages slurm-wlm, munge and snakemake.
set -euo pipefail
if pgrep -x "slurmd|slurmctld" > /dev/null; then
  echo "error: this machine runs Slurm, whose jobs the test would stop. Run it elsewhere." >&2
  exit 1
fi
unset SLURM_CONF
source=$(cd "$(dirname "$0")/../.." && pwd)
command=$(realpath "$1")
cohort=$source/apps/cohort/trephine-cohort
export XDG_STATE_HOME XDG_CACHE_HOME
work=$(mktemp -d)
XDG_STATE_HOME=$work/home XDG_CACHE_HOME=$work/home
node=$(hostname -s)

stop() {
  status=$?
  [ -z "${SLURM_CONF:-}" ] || scancel --user=root 2>/dev/null || true
  for name in d ctld munge/munged; do
    [ ! -f "$work/slurm/$name.pid" ] || kill "$(cat "$work/slurm/$name.pid")" 2>/dev/null || true
  done
  if [ $status != 0 ]; then
    [ ! -f "$work/two.csv" ] || diff "$work/one.csv" "$work/two.csv" | cut -c 1-200 | head -n 10 || true
    tail -n 5 "$work"/{first,second,third}.log "$work"/slurm/{ctld,d}.log 2>/dev/null || true
  fi
  sleep 1
  rm -rf "$work"
  exit $status
}
trap stop EXIT

# ---- the cases ----
"$command" phantom sphere --spacing 2 -o "$work/ball.mha" > "$work/phantom.log"
cat > "$work/drill.toml" <<TOML
schema = 1
title = "A short drill"
scan = "ball.mha"
iso = 300
[[hands]]
instrument = "burr"
parameters = "diameter=6"
points = [[0, 0, 0, 60, 0], [0.5, 0, 0, 40, 1], [1, 0, 0, 30, 1], [1.2, 0, 0, 60, 0]]
TOML
mkdir "$work/broken"
head -c 3000 /dev/urandom > "$work/broken/image.dcm"
sed 's|^scan = .*|scan = "broken"|' "$work/drill.toml" > "$work/no-scan.toml"
{
  echo case,script,skill,seed
  for number in $(seq 1 199); do
    skills=(novice trained expert)
    echo "$(printf %05d "$number"),drill.toml,${skills[number % 3]},$number"
  done
  echo 00200,no-scan.toml,novice,1
} > "$work/plan.csv"

# ---- the undisturbed run ----
"$cohort" run "$work/plan.csv" "$work/one" --trephine "$command" 2> "$work/one.log"
expected=$("$cohort" merge "$work/plan.csv" "$work/one" -o "$work/one.csv" | tail -n 1)
grep -q '^00200,novice,1,.*DICOM\|^00200,novice,1,.*scan\|^00200,novice,1,.*file' "$work/one.csv"
echo "undisturbed: $expected"

# ---- a cluster of one machine ----
mkdir -p "$work"/slurm/{state,spool,munge}
chmod 700 "$work/slurm/munge"
head -c 1024 /dev/urandom > "$work/slurm/munge.key"
chmod 400 "$work/slurm/munge.key"
munged --key-file="$work/slurm/munge.key" --socket="$work/slurm/munge/socket" --pid-file="$work/slurm/munge/munged.pid" \
  --log-file="$work/slurm/munge.log" --seed-file="$work/slurm/munge/seed" --force
cat > "$work/slurm/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$node(127.0.0.1)
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$work/slurm/munge/socket
StateSaveLocation=$work/slurm/state
SlurmdSpoolDir=$work/slurm/spool
SlurmctldPidFile=$work/slurm/ctld.pid
SlurmdPidFile=$work/slurm/d.pid
SlurmctldLogFile=$work/slurm/ctld.log
SlurmdLogFile=$work/slurm/d.log
SlurmctldPort=16817
SlurmdPort=16818
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
ReturnToService=2
SlurmdTimeout=10
MpiDefault=none
NodeName=$node NodeAddr=127.0.0.1 CPUs=$(nproc) State=UNKNOWN
PartitionName=all Nodes=$node Default=YES MaxTime=INFINITE State=UP
CONF
export SLURM_CONF=$work/slurm/slurm.conf
slurmctld
slurmd
for _ in $(seq 30); do
  sinfo --noheader --format=%t | grep -q idle && break
  sleep 1
done

# ---- the run with kills ----
snakes() {
  snakemake --snakefile "$source/apps/cohort/Snakefile" --directory "$work" --jobs "$(nproc)" --keep-going \
    --rerun-incomplete --retries 2 --latency-wait 20 --nolock \
    --cluster "sbatch --parsable --chdir=$work --output=$work/job-%j.log --cpus-per-task=1" \
    --config plan="$work/plan.csv" results="$work/two" parts=20 cohort="$cohort" trephine="$command"
}
count() { find "$work/two" -maxdepth 1 -name '0*.json' 2>/dev/null | wc -l; }
wait_for() { # $1: number of results
  for _ in $(seq 600); do
    [ "$(count)" -lt "$1" ] || return 0
    sleep 0.5
  done
  echo "error: fewer than $1 results after 300 s" >&2
  return 1
}
setsid bash -c "$(declare -f snakes); source='$source' work='$work' cohort='$cohort' command='$command'; snakes" \
  > "$work/first.log" 2>&1 &
snake=$!
wait_for 25
kill -9 -- "-$snake"
pkill -9 -f "$cohort run" || true
pkill -9 -f "$command run" || true
echo "Snakemake and the running cases were killed after $(count) results"
scancel --user=root || true
setsid bash -c "$(declare -f snakes); source='$source' work='$work' cohort='$cohort' command='$command'; snakes" \
  > "$work/second.log" 2>&1 &
snake=$!
wait_for 80
kill -9 "$(cat "$work/slurm/d.pid")"
pkill -9 -x slurmstepd || true
pkill -9 -f "$cohort run" || true
pkill -9 -f "$command run" || true
echo "slurmd and its jobs were killed after $(count) results"
kill -9 -- "-$snake" 2>/dev/null || true
sleep 2
scancel --user=root || true
slurmd
sleep 2
scontrol update nodename="$node" state=resume 2>/dev/null || true
before=$(count)
snakes > "$work/third.log" 2>&1
echo "continued from $before results to $(count)"
actual=$("$cohort" merge "$work/plan.csv" "$work/two" -o "$work/two.csv" | tail -n 1)
echo "on Slurm:    $actual"
[ "$actual" = "$expected" ]
