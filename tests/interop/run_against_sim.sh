#!/usr/bin/env bash
# bash tests/interop/run_against_sim.sh GANTRY MASTER...: each strange master against a simulated machine of its own, over a
# veth pair; tshark judges the frames. A run that failed while the host stood still is repeated (run.py, exit 75).
# Exit 77 where no veth pair may be made. KEEP_CAPTURES=DIR keeps the captures.
set -uo pipefail
gantry=$(realpath "$1"); shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
name=gio$$
source tests/interop/veth_line.sh
machine=${MACHINE:-config/machines/dispenser.yaml}
failures=0
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }

# once MASTER: a fresh simulated machine and one master
once() {
  scripts/veth-pair exec $name -- "$gantry" --machine "$machine" sim --interface $name-sim >"$work/sim.out" 2>&1 </dev/null &
  far=$!
  for _ in $(seq 100); do grep -qs "simulated machine" "$work/sim.out" && break; sleep 0.05; done
  sleep 0.3
  scripts/veth-pair exec $name -- env PYTHONDONTWRITEBYTECODE=1 python3 tests/interop/run.py "$1" $name-ctl "$machine" "$work/$1.pcapng"
  local code=$?
  kill $far; wait $far 2>/dev/null; far=
  return $code
}

for master in "$@"; do
  for attempt in 1 2 3; do
    echo "== $master, attempt $attempt"
    once "$master"; code=$?
    [ $code = 75 ] || break
  done
  [ $code = 0 ] || fail "$master: exit $code"
  bad=$(tshark -r "$work/$master.pcapng" -Y '_ws.malformed' 2>/dev/null | wc -l)
  frames=$(tshark -r "$work/$master.pcapng" -Y ecat 2>/dev/null | wc -l)
  [ "$frames" -gt 100 ] && [ "$bad" = 0 ] && echo "ok: $frames frames, none malformed" || fail "$frames frames, $bad malformed"
  [ -z "${KEEP_CAPTURES:-}" ] || cp "$work/$master.pcapng" "$KEEP_CAPTURES/"
done
[ "$failures" = 0 ]
