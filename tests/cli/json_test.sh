#!/usr/bin/env bash
# One JSON shape for all verbs: `result`, `exit_code` and `errors` stand in front, and the exit code is that of the program.
source "$(dirname "$0")/lib.sh"
use_patient_machine
"$gantry" up --state "$work/state" >"$work/up.log" 2>&1 &
pids+=($!)
wait_for 60 "$gantry" status --state "$work/state" || { tail -5 "$work/up.log"; fail "no owner comes up"; }
python3 tests/cli/json_test.py "$gantry" "$work" || failures=$((failures + 1))
