#!/usr/bin/env bash
# bash bench/veth_exchange/run.sh [BUILD_DIR] [ROUNDS] [CYCLES] [WAIT_US]: round trip of our master's cyclic frame (eight stations, 1 ms,
# against `gantry sim` in a process of its own) beside a plain AF_PACKET ping-pong of the same size with the same pinning
# in the same run. Both placements: master and far end on one CPU, and on two. The order is swapped every round. Needs root.
# Prints the median and p99 of each run, and the ratios.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
build=${1:-build/release} rounds=${2:-7} cycles=${3:-3000} wait_us=${4:-400}
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

# once WHAT PLACEMENT FAR_CPU
once() {
  local good=yes
  if [ "$1" = ours ]; then
    taskset -c "$3" scripts/veth-pair exec $name -- "$build/bin/gantry" -q --machine $machine sim --interface $name-sim </dev/null >/dev/null 2>&1 &
  else
    taskset -c "$3" scripts/veth-pair exec $name -- "$build/bin/veth_exchange" echo --interface $name-sim </dev/null >/dev/null 2>&1 &
  fi
  far=$!
  sleep 0.7
  taskset -c 0 scripts/veth-pair exec $name -- "$build/bin/veth_exchange" --machine $machine "$1" --interface $name-ctl --cycles "$cycles" --size "$size" --wait "$wait_us" |
    sed "s/^/$2 $1 /" >"$work/run" || good=
  kill $far; wait $far 2>/dev/null || true
  far=
  [ -n "$good" ] && tee -a "$results" <"$work/run"
}
# The same; again where the host stood still so long that the line did not come to OP.
one() { once "$@" || once "$@" || once "$@"; }

size=$(one ours warm-up 1 | sed 's/.*size //')
: >"$results"
echo "frame of $size bytes, $cycles cycles of 1 ms; microseconds"
for ((round = 0; round < rounds; ++round)); do
  for placement in "same-cpu 0" "cross-cpu 1"; do
    set -- $placement
    if ((round % 2 == 0)); then one plain "$1" "$2"; one ours "$1" "$2"; else one ours "$1" "$2"; one plain "$1" "$2"; fi
  done
done
# The two runs of a round lie side by side: their ratio, as the median of the rounds and its range.
ratio() { # PLACEMENT COLUMN
  awk -v place="$1" -v column="$2" '$1 == place {v[$2, ++n[$2]] = $column}
    END {for (i = 1; i <= n["ours"]; ++i) print v["ours", i] / v["plain", i]}' "$results" | sort -n |
    awk '{r[NR] = $1} END {printf "%.2f (%.2f to %.2f)", (r[int((NR + 1) / 2)] + r[int(NR / 2) + 1]) / 2, r[1], r[NR]}'
}
for placement in same-cpu cross-cpu; do
  echo "$placement: median ratio $(ratio $placement 4), p99 ratio $(ratio $placement 6); targets 1.40 and 1.60"
done
