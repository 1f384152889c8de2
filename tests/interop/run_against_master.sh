#!/usr/bin/env bash
# bash tests/interop/run_against_master.sh OUR_MASTER KIND...: the project's master against a line of strange stations, over
# a veth pair; tshark judges the frames. Exit 77 where no veth pair may be made. KEEP_CAPTURES=DIR keeps the capture.
set -uo pipefail
program=$(realpath "$1"); shift
cd "$(dirname "${BASH_SOURCE[0]}")/../.." || exit 1
name=gim$$
source tests/interop/veth_line.sh
scripts/veth-pair exec $name -- env PYTHONDONTWRITEBYTECODE=1 python3 tests/interop/strange_stations.py $name-sim "$@" \
  --capture "$work/capture.pcapng" >"$work/out" 2>&1 </dev/null &
far=$!
for _ in $(seq 100); do grep -qs "strange stations on" "$work/out" && break; sleep 0.05; done
failures=0
scripts/veth-pair exec $name -- "$program" $name-ctl "$@" || failures=1
kill $far; wait $far; far=
cat "$work/out"
bad=$(tshark -r "$work/capture.pcapng" -Y '_ws.malformed' 2>/dev/null | wc -l)
frames=$(tshark -r "$work/capture.pcapng" -Y ecat 2>/dev/null | wc -l)
[ "$frames" -gt 100 ] && [ "$bad" = 0 ] && echo "ok: $frames frames, none malformed" || { echo "FAILED: $frames frames, $bad malformed"; failures=1; }
[ -z "${KEEP_CAPTURES:-}" ] || cp "$work/capture.pcapng" "$KEEP_CAPTURES/our_master.pcapng"
[ "$failures" = 0 ]
