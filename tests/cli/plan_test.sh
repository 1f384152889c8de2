#!/usr/bin/env bash
# gantry plan: paths and motions among the bodies of scene documents, judged in another language.
source "$(dirname "$0")/lib.sh"
python3 tests/cli/plan_test.py "$gantry" "$work" && echo "ok: plans" || fail "gantry plan"
