#!/usr/bin/env bash
# What the operator's keys do: hold, resume, override, abort.
source "$(dirname "$0")/lib.sh"
python3 -c 'import pty; pty.openpty()' 2>/dev/null || {
  echo "skipped: no terminal can be made here (mount -t devpts devpts /dev/pts)"
  exit 77
}
use_patient_machine
python3 tests/cli/keys_test.py "$gantry" tests/cli/short-board.yaml "$work" || failures=$((failures + 1))
