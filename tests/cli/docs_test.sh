#!/usr/bin/env bash
# README.md and docs/ name nothing that is not there.
exec python3 "$(dirname "$0")/docs_test.py" "$(realpath "$1")" "$(realpath "$(dirname "$0")/../..")"
