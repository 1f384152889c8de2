#!/usr/bin/env bash
# A cable between an owner and a simulated machine that stands still, is started again, or is wanted by a second owner.
source "$(dirname "$0")/lib.sh"
machine=$(patient_machine)
name=gcab$$
cable $name
scripts/veth-pair exec $name -- python3 tests/cli/cable_test.py "$gantry" "$machine" $name "$work" || failures=$((failures + 1))
