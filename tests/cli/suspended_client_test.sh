#!/usr/bin/env bash
# Ctrl-Z in a `gantry run` that is a client of `gantry up`: the machine is held before the client stops.
source "$(dirname "$0")/lib.sh"
python3 -c 'import pty; pty.openpty()' 2>/dev/null || {
  echo "skipped: no terminal can be made here (mount -t devpts devpts /dev/pts)"
  exit 77
}
use_patient_machine
state=$work/state
"$gantry" up --state "$state" >"$work/up.out" 2>&1 </dev/null &
pids+=($!)
wait_for 40 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
python3 tests/cli/suspended_client_test.py "$gantry" tests/cli/short-board.yaml "$work" "$state" ||
  failures=$((failures + 1))
