#!/usr/bin/env bash
# The operator's verbs: nobody who owns the machine, an owner that is idle, one that runs a job, and its end.
source "$(dirname "$0")/lib.sh"
program=$gantry
use_patient_machine
state=$work/state
verbs="status hold resume abort reset enable disable park down"
order() { "$gantry" "$@" --state "$state"; }
# says KEY VALUE: of the JSON document in $work/out
says() {
  python3 - "$work/out" "$1" "$2" <<'PY' || fail "'$1' is not '$2'"
import json, sys
answer = json.load(open(sys.argv[1]))
assert str(eval("answer" + sys.argv[2])) == sys.argv[3], answer
PY
}

for verb in $verbs "override 50"; do
  # shellcheck disable=SC2086
  expect_exit 7 "$verb, and no owner" order $verb
  expect_text 'start one with `gantry up`'
  # shellcheck disable=SC2086
  expect_exit 7 "$verb, and no owner, as JSON" order --json $verb
  says "['exit_code']" 7
  expect_exit 0 "${verb% *} --help" "$gantry" "${verb% *}" --help
done
expect_exit 2 "override without a number" order override
expect_exit 2 "override by a word" order override fast

"$gantry" up --state "$state" >"$work/up.out" 2>&1 </dev/null &
owner=$!; pids+=($owner)
wait_for 40 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
expect_exit 0 "status" order --json status
says "['state']" disabled
says "['faults']" "[]"
says "['axes'][0]['enabled']" False
expect_exit 0 "status in words" order status
expect_text "torque off, not referenced"
expect_exit 7 "nothing to hold" order hold
expect_text "'hold' is refused: the machine is disabled, and nothing is under way that could be held; nothing has to be done"
expect_exit 7 "nothing to resume" order resume
expect_exit 0 "half speed" order --json override 50
expect_exit 0 "status of it" order --json status
says "['override']" 0.5
expect_exit 2 "five times the speed" order override 500
expect_text "or 1 to 200, 100 for the recipe"
expect_exit 7 "more than the machine allows" order override 150
expect_text "at most 100 % (.override_max. of its file)"
expect_exit 0 "full speed" order override 100
cp config/machines/dispenser.yaml "$work/config/machines/another.yaml" && echo >>"$work/config/machines/another.yaml"
for verb in status enable disable reset park down part-removed "override 90"; do
  # shellcheck disable=SC2086
  expect_exit 2 "$verb of another machine" "$program" --machine "$work/config/machines/another.yaml" $verb --state "$state"
  expect_text "the owner that is up has '.*patient.yaml', and '.*another.yaml' was asked for"
done
expect_exit 0 "a stop is never refused" "$program" --machine "$work/config/machines/another.yaml" abort --state "$state"
expect_exit 7 "park, and nobody knows where the head stands" order park
expect_text 'run `gantry home` first'
expect_exit 0 "home through the owner" order --json home
says "['state']" ready
says "['axes'][0]['referenced']" True
expect_exit 0 "park" order --json park
says "['state']" ready
says "['axes'][0]['name'] + ' %.3f' % answer['axes'][0]['position']" "X 20.000"
expect_exit 0 "disable" order --json disable
says "['axes'][0]['enabled']" False
expect_exit 0 "enable" order --json enable
says "['axes'][0]['enabled']" True

"$gantry" run tests/cli/short-board.yaml --state "$state" --out "$work/job" >"$work/job.out" 2>&1 </dev/null &
job=$!; pids+=($job)
running() { order --json status 2>/dev/null | grep -q '"state": "running"'; }
wait_for 40 running || fail "the job does not run"
wait_for 5 order hold --now || fail "it takes no hold"
held() { order --json status 2>/dev/null | grep -q '"state": "held"'; }
wait_for 5 held || fail "it is not held"
expect_exit 0 "a job in words" order status
expect_text "^held, automatic, override 100 %, door closed"
expect_text "^job: [0-9] of 3 features, .* s gone"
expect_text "^     .*/short-board.yaml$"
expect_text '^held by the order `hold`; `gantry resume` goes on, `gantry abort` ends it'
expect_exit 0 "the same as JSON" order --json status
says "['held'], answer['held_by']['by'], answer['busy_with'], answer['door'], answer['mode']" "(True, 'order', 'run', 'closed', 'automatic')"
wait_for 5 grep -q 'held by the order `hold` of another client; `gantry resume` goes on' "$work/job.out" ||
  { fail "its client is not told"; cat "$work/job.out"; }
expect_exit 7 "an order that takes time" order part-removed
expect_text "'part_removed' is refused: the machine is busy with 'run' (held), which is on hold; .resume. goes on, .abort. ends it"
expect_exit 0 "resume" order resume
kill -HUP $job; wait $job; code=$?
[ $code = 130 ] && echo "ok: the client is lost" || { fail "a lost client gave $code"; cat "$work/job.out"; }
expect_exit 0 "down in a job that goes on without its client" order down
wait $owner; code=$?
[ $code = 0 ] && echo "ok: the owner has ended" || { fail "the owner ended with $code"; tail -3 "$work/up.out"; }
grep -q '"result": "interrupted"' "$work/job/summary.json" && echo "ok: the job's summary tells it" || fail "no summary of the job"

# An owner that nobody's terminal holds does not care when one goes.
setsid "$gantry" up --state "$state" >"$work/up2.out" 2>&1 </dev/null &
pids+=($!)
wait_for 40 grep -q "is up" "$work/up2.out" || fail "the second owner did not come up"
kill -HUP "${pids[-1]}"; sleep 0.3
expect_exit 0 "a service after SIGHUP" order status
expect_exit 0 "down" order down
# Whose process is over waits for this shell alone (proc(5), state Z).
case "$(sed 's/.*) //' "/proc/${pids[-1]}/stat" 2>/dev/null)" in
  "" | Z*) echo "ok: the owner's process has ended when \`down\` says so" ;;
  *) fail "the owner's process goes on behind \`down\`" ;;
esac
