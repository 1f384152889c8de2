#!/usr/bin/env bash
# Long work shows itself on a terminal, and only there; log lines stand in lines of their own; NO_COLOR is obeyed.
source "$(dirname "$0")/lib.sh"
exec python3 tests/cli/shows_itself_test.py "$gantry" "$work"
