#!/usr/bin/env bash
# The simulated machine in a process of its own, behind a network interface: same deposits, same setpoints, clean frames.
source "$(dirname "$0")/lib.sh"
job=tests/cli/short-board.yaml
machine=$(patient_machine)
name=gcli$$
cable $name
inside() { scripts/veth-pair exec $name -- "$@"; }

expect_exit 0 "in virtual time" "$gantry" dry-run $job --out "$work/dry"
inside "$gantry" --machine "$machine" sim --interface $name-sim --world "$work/world" >"$work/sim.out" 2>&1 </dev/null &
pids+=($!)
wait_for 10 test -S "$work/world" || { fail "no world socket"; cat "$work/sim.out"; }
command -v tshark >/dev/null || fail "no tshark; scripts/setup installs it"
inside tshark -i $name-ctl -a duration:30 -w "$work/bus.pcapng" >/dev/null 2>&1 </dev/null &
shark=$!; pids+=($shark)
sleep 1.5
expect_exit 0 "over a wire" inside "$gantry" --machine "$machine" run $job --bus ethercat:$name-ctl --world "$work/world" --state "$work/none" --out "$work/wire"
same_setpoints "$work/dry" "$work/wire" "over a wire"
python3 - "$work/dry" "$work/wire" <<'E' && echo "ok: same deposits" || fail "other deposits over the wire"
import json, sys
dry, wire = (json.load(open(f + "/summary.json")) for f in sys.argv[1:3])
lost = wire["cycle"]["skipped"] + wire["cycle"]["frames_lost"]  # each may shift an end by a cycle's travel
dry, wire = ({d["id"]: d for d in s["deposits"]} for s in (dry, wire))
assert dry.keys() == wire.keys() == {"a", "b", "corner"}, (dry.keys(), wire.keys())
for name, d in dry.items():  # the loop's clock moves against SYNC0: half a cycle at the speed of the bead, and a hair
    off = max(abs(x - y) for end in (0, -1) for x, y in zip(d["board_mm"][end], wire[name]["board_mm"][end]))
    assert off < 0.02 * (1 + lost), (name, off, lost)
E
wait $shark
frames=$(tshark -r "$work/bus.pcapng" -Y ecat 2>/dev/null | wc -l)
bad=$(tshark -r "$work/bus.pcapng" -Y '_ws.malformed' 2>/dev/null | wc -l)
[ "$frames" -gt 100 ] && [ "$bad" = 0 ] && echo "ok: $frames frames, none malformed" || fail "$frames frames, $bad malformed"

# One interface, one owner: whoever comes second is told who has it, and the first one does not notice.
inside "$gantry" --machine "$machine" up --bus ethercat:$name-ctl --world "$work/world" --state "$work/first" >"$work/up.out" 2>&1 </dev/null &
first=$!; pids+=($first)
is_up() { "$gantry" --json status --state "$work/first" | grep -q '"state": "disabled"'; }
wait_for 30 is_up || { fail "no owner came up"; cat "$work/up.out"; }
owner=$(pgrep -P "$first" gantry)
for second in "up" "run $job --out $work/second" "home"; do
  expect_exit 7 "a second owner by '${second%% *}' is refused" \
    inside "$gantry" --machine "$machine" $second --bus ethercat:$name-ctl --state "$work/other"
  for words in "G703" "$name-ctl" "process $owner (gantry)"; do expect_text "$words"; done
done
is_up && ! grep -qE "G[0-9]{3}" "$work/up.out" && echo "ok: the first owner did not notice" || { fail "the first owner was disturbed"; cat "$work/up.out"; }
kill "$owner"; wait "$first"
