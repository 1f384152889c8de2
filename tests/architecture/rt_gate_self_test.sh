#!/usr/bin/env bash
# rt_gate_self_test.sh GATE ALLOWED CLEAN PATTERN=ARCHIVE...: the gate passes the clean archive, and refuses each of the
# others with a message that matches its pattern. A gate that cannot fail is none.
set -euo pipefail
gate=$1 allowed=$2 clean=$3
shift 3
bash "$gate" "$allowed" "$clean" || { echo "the clean archive was refused"; exit 1; }
for planted in "$@"; do
  pattern=${planted%%=*} archive=${planted#*=}
  if said=$(bash "$gate" "$allowed" "$clean" "$archive"); then
    echo "passed, but must not: $archive"
    exit 1
  fi
  grep -q "$pattern" <<<"$said" || { echo "$archive: '$pattern' not named in: $said"; exit 1; }
done
echo "$# planted archives refused"
