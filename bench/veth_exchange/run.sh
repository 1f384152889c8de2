#!/usr/bin/env bash
# bash bench/veth_exchange/run.sh [BUILD_DIR] [ROUNDS] [CYCLES] [WAIT_US]: round trip of our master's cyclic frame (eight stations, 1 ms,
# against `gantry sim` in a process of its own) beside a plain AF_PACKET ping-pong of the same size with the same pinning
# in the same run. Both placements: master and far end on one CPU, and on two. The order is swapped every round. Needs root.
# Prints the median and p99 of each round, and the ratios of all rounds.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=${1:-build/release} rounds=${2:-4} cycles=${3:-3000} wait_us=${4:-400}
name=gbench$$
scripts/veth-pair up $name
far=
finish() { [ -n "$far" ] && kill "$far" 2>/dev/null; wait 2>/dev/null; scripts/veth-pair down $name; rm -rf "$work"; }
work=$(mktemp -d)
results=$work/results
trap finish EXIT

# The reference machine's line of six, and two drives more without an axis.
mkdir "$work/machines"
ln -s "$PWD/config/drives" "$PWD/config/devices" "$work"
sed '/^  io: /a\  e1: {profile: id286, position: 6}\n  e2: {profile: id286, position: 7}' config/machines/dispenser.yaml >"$work/machines/eight.yaml"
machine=$work/machines/eight.yaml
size=300

# one WHAT PLACEMENT FAR_CPU
one() {
  if [ "$1" = ours ]; then
    taskset -c "$3" scripts/veth-pair exec $name -- "$build/bin/gantry" -q --machine $machine sim --interface $name-sim </dev/null >/dev/null 2>&1 &
  else
    taskset -c "$3" scripts/veth-pair exec $name -- "$build/bin/veth_exchange" echo --interface $name-sim </dev/null >/dev/null 2>&1 &
  fi
  far=$!
  sleep 0.7
  taskset -c 0 scripts/veth-pair exec $name -- "$build/bin/veth_exchange" --machine $machine "$1" --interface $name-ctl --cycles "$cycles" --size "$size" --wait "$wait_us" |
    sed "s/^/$2 $1 /" | tee -a "$results"
  kill $far; wait $far 2>/dev/null || true
  far=
}

size=$(one ours warm-up 1 | sed 's/.*size //')
: >"$results"
echo "frame of $size bytes, $cycles cycles of 1 ms; microseconds"
for ((round = 0; round < rounds; ++round)); do
  for placement in "same-cpu 0" "cross-cpu 1"; do
    set -- $placement
    if ((round % 2 == 0)); then one plain "$1" "$2"; one ours "$1" "$2"; else one ours "$1" "$2"; one plain "$1" "$2"; fi
  done
done
for placement in same-cpu cross-cpu; do
  awk -v place=$placement '$1 == place {n[$2]++; lm[$2] += log($4); lp[$2] += log($6); if (!($2 in bm) || $4 < bm[$2]) bm[$2] = $4; if (!($2 in bp) || $6 < bp[$2]) bp[$2] = $6}
    END {printf "%s: median ratio %.2f (best rounds %.2f), p99 ratio %.2f (best rounds %.2f); targets 1.40 and 1.60\n", place,
      exp(lm["ours"] / n["ours"] - lm["plain"] / n["plain"]), bm["ours"] / bm["plain"],
      exp(lp["ours"] / n["ours"] - lp["plain"] / n["plain"]), bp["ours"] / bp["plain"]}' "$results"
done
