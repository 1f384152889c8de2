#!/usr/bin/env bash
# An owner that is up, and its clients: floods, dead clients, jobs through it, options that are not its own, links.
source "$(dirname "$0")/lib.sh"
shipped=$gantry
use_patient_machine
python3 tests/cli/owner_test.py "$gantry" "$work" "$shipped" || failures=$((failures + 1))
