#!/usr/bin/env bash
# A verb that proves a recipe ends as soon as it is asked to, before anything moves.
source "$(dirname "$0")/lib.sh"
python3 -c 'import pty; pty.openpty()' 2>/dev/null || {
  echo "skipped: no terminal can be made here (mount -t devpts devpts /dev/pts)"
  exit 77
}
python3 tests/cli/interrupted_proof_test.py "$gantry" "$work" || failures=$((failures + 1))
