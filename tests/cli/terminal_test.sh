#!/usr/bin/env bash
# What ends a job on a terminal, what does not hold it up, and Ctrl-Z.
source "$(dirname "$0")/lib.sh"
python3 -c 'import pty; pty.openpty()' 2>/dev/null || {
  echo "skipped: no terminal can be made here (mount -t devpts devpts /dev/pts)"
  exit 77
}
use_patient_machine
python3 tests/cli/terminal_test.py "$gantry" tests/cli/short-board.yaml "$work" || failures=$((failures + 1))
