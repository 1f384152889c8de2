#!/usr/bin/env bash
# A simulated machine whose bus goes on while its camera and its world keep silent: orders and signals are heard
# meanwhile, and nobody waits for the world whom an abort or a signal has told not to, or for one that stands with its bus.
source "$(dirname "$0")/lib.sh"
machine=$(patient_machine)
name=gsil$$
cable $name
inside() { scripts/veth-pair exec $name -- "$@"; }

inside sh -c 'echo $$ >"$0"; exec "$@"' "$work/sim.pid" "$gantry" --machine "$machine" sim --interface $name-sim --world "$work/world" >"$work/sim.out" 2>&1 </dev/null &
pids+=($!)
wait_for 10 test -S "$work/world" || { fail "no world socket"; cat "$work/sim.out"; }
inside python3 tests/cli/silent_world_test.py "$gantry" "$machine" "$work" ethercat:$name-ctl || failures=$((failures + 1))
