#!/usr/bin/env bash
# bash planted_test.sh PROGRAM CORPUS: the target with a planted bug must be caught, by the very runs that the others get.
cd "$(mktemp -d)" || exit 1
"$1" "$2" 200000 >out 2>&1
code=$?
found=$(find . -name 'fuzz-crash-*' | wc -l)
[ $code -ne 0 ] && [ "$found" = 1 ] && grep -q "the input stands in" out && echo "the planted bug was found" && exit 0
echo "the planted bug was not found: exit $code"; cat out; exit 1
