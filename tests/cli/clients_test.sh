#!/usr/bin/env bash
# What clients of an owner say and show, beside an owner that the test plays itself.
source "$(dirname "$0")/lib.sh"
python3 tests/cli/clients_test.py "$gantry" "$work" || failures=$((failures + 1))
