#!/usr/bin/env bash
# rt_gate.sh ALLOWED ARCHIVE...: the archives of the RT side may need nothing but each other and the symbols of ALLOWED
# (a file of extended regular expressions, one a line). Whatever else stands among their undefined symbols, such as
# operator new, __cxa_throw, pthread_mutex_lock or printf, is named with the object that wants it, and fails.
set -euo pipefail
[ $# -ge 2 ] || { echo "usage: rt_gate.sh ALLOWED ARCHIVE..." >&2; exit 2; }
allowed=$(sed 's/[ \t]*#.*//' "$1" | grep -v '^$' | paste -sd '|')
shift

# `nm -A -P` prints "archive[member.o]: symbol type value size".
symbols=$(nm -A -P "$@")
needed=$(awk '$3 == "U" || $3 == "w" || $3 == "v" { print $2 }' <<<"$symbols" | sort -u)
defined=$(awk '$3 != "U" && $3 != "w" && $3 != "v" { print $2 }' <<<"$symbols" | sort -u)
[ -n "$defined" ] || { echo "rt_gate: the archives define nothing; is this the right list?" >&2; exit 2; }

status=0
while read -r symbol; do
  [ -n "$symbol" ] || continue
  status=1
  who=$(awk -v s="$symbol" '$2 == s && ($3 == "U" || $3 == "w" || $3 == "v") { sub(/:$/, "", $1); sub(/.*\//, "", $1); print $1 }' \
    <<<"$symbols" | sort -u | paste -sd ' ')
  echo "rt_gate: $(c++filt "$symbol") is not for the RT loop; wanted by $who"
done < <(comm -23 <(echo "$needed") <(echo "$defined") | grep -vxE "$allowed" || [ $? -eq 1 ])
exit $status
