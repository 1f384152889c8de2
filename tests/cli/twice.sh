#!/usr/bin/env bash
# bash tests/cli/twice.sh TEST GANTRY: a test of the program in real time. A host that stands still for long ends a run
# rightly, at any place; a test that failed is therefore tried once more, and what it said the first time stays on show.
bash "$@"
code=$?
[ "$code" = 0 ] || [ "$code" = 77 ] && exit "$code"
echo "$(basename "$1") failed (exit $code); once more, as the host may have stood still"
exec bash "$@"
