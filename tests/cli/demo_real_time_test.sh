#!/usr/bin/env bash
# The demo board under the wall clock sends what its dry run sends. 50 s, most of them asleep.
source "$(dirname "$0")/lib.sh"
demo=recipes/demo-board.yaml
use_patient_machine
expect_exit 0 "in virtual time" "$gantry" dry-run $demo --out "$work/dry"
expect_exit 0 "in real time" "$gantry" run $demo --state "$work/none" --out "$work/real"
same_setpoints "$work/dry" "$work/real" "in real time"
