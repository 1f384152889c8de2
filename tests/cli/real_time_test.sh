#!/usr/bin/env bash
# The same short job in virtual time, in real time, through an owner that is up, and interrupted. Nothing here depends on how punctual the host is.
source "$(dirname "$0")/lib.sh"
job=tests/cli/short-board.yaml
use_patient_machine

expect_exit 0 "in virtual time" "$gantry" dry-run $job --out "$work/dry"
expect_exit 0 "in real time" "$gantry" run $job --state "$work/none" --out "$work/real"
same_setpoints "$work/dry" "$work/real" "in real time"

# Without the rights for real time the job runs, and says so.
taken=-sys_nice,-ipc_lock,-sys_resource
[ "$(id -u)" = 0 ] && plain=(setpriv --bounding-set=$taken --inh-caps=$taken) || plain=()
expect_exit 0 "without real-time rights" "${plain[@]}" bash -c 'ulimit -l 64; ulimit -r 0; exec "$@"' _ "$gantry" run $job \
  --state "$work/none" --out "$work/plain"
expect_text "no real-time rights"
grep -q '"real_time_priority":false,"memory_locked":false' "$work/plain/summary.json" || fail "the summary claims rights"
same_setpoints "$work/dry" "$work/plain" "without real-time rights"

# The publisher's death costs nothing.
"$gantry" run $job --state "$work/none" --out "$work/killed" >"$work/k.out" 2>&1 </dev/null &
runner=$!; pids+=($runner)
if wait_for 5 pgrep -P $runner; then kill -9 "$(pgrep -P $runner | head -1)" && echo "ok: publisher killed"; else fail "no publisher was started"; fi
wait $runner || fail "the job did not survive its publisher's death"
same_setpoints "$work/dry" "$work/killed" "with the publisher killed"

"$gantry" run $job --state "$work/none" --out "$work/int" >"$work/i.out" 2>&1 </dev/null &
runner=$!; pids+=($runner)
wait_for 20 grep -q "homing X" "$work/i.out"; sleep 2
kill -INT $runner; wait $runner; code=$?
[ $code = 130 ] && echo "ok: Ctrl-C" || { fail "Ctrl-C gave $code"; tail -5 "$work/i.out"; }
grep -q '"result": "interrupted"' "$work/int/summary.json" || fail "the summary does not say interrupted"

"$gantry" up --state "$work/state" >"$work/up.out" 2>&1 </dev/null &
owner=$!; pids+=($owner)
wait_for 20 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; exit 1; }
expect_exit 7 "a second owner" "$gantry" up --state "$work/state"
expect_exit 0 "home as a client" "$gantry" home --state "$work/state"
expect_exit 0 "a job as a client" "$gantry" --json run $job --state "$work/state" --out "$work/client"
same_setpoints "$work/dry" "$work/client" "through the owner"
kill -TERM $owner; wait $owner && echo "ok: the owner ends in order" || fail "the owner did not end in order"
