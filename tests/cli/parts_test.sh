#!/usr/bin/env bash
# A part that was begun and not finished, as its operator sees it: through an owner, by `run` alone, after a power cut.
source "$(dirname "$0")/lib.sh"
use_patient_machine
short=tests/cli/short-board.yaml
state=$work/state
echo '- {at: feature bead 1, after: 300 ms, do: press, input: stop, hold: 100 ms}' >"$work/stop.yaml"
order() { "$gantry" "$@" --state "$state"; }
start_owner() { # OPTIONS...
  "$gantry" up --state "$state" "$@" >"$work/up.out" 2>&1 </dev/null &
  owner=$!
  pids+=("$owner")
  wait_for 40 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
}
end_owner() { expect_exit 0 "down" order down; wait "$owner"; }
reset() { # once the stop button is up again
  wait_for 10 sh -c "'$gantry' status --state '$state' | grep -q 'the stop button is pressed - not any more'" ||
    fail "the stop button is still pressed"
  expect_exit 0 "reset" order reset
}
# Stopped by the button, a job of an owner waits: it is given up as soon as the button is up again.
give_up_when_stopped() {
  (wait_for 60 sh -c "'$gantry' status --state '$state' | grep -q 'the stop button is pressed - not any more'" &&
    "$gantry" abort --state "$state" >/dev/null) &
  pids+=($!)
}
says() { python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert str(eval("d" + sys.argv[2])) == sys.argv[3], d' \
  "$work/out" "$1" "$2" || fail "'$1' is not '$2'"; }
run() { local code=$1 what=$2; shift 2; expect_exit "$code" "$what" order run $short --out "$work/job" --force "$@"; }

start_owner --sim-script "$work/stop.yaml"
give_up_when_stopped
run 7 "a bead is cut by the stop button" --serial S-1
expect_text "board          begun"
expect_text "cut            'corner'"
expect_text "to finish it   gantry run .*short-board.yaml --only corner --serial S-1"
ls "$state"/begun-sim/part-*.json >/dev/null 2>&1 || fail "nothing is remembered in the state folder"
reset
run 7 "the same part again" --serial S-1
expect_text "the part with serial 'S-1' was begun at 20.*Z and not finished: 1 of its 3 features is not whole"
expect_text "finish it with --only corner, or say .gantry part-removed --serial S-1. when it is taken out"
run 7 "the same part again, as JSON" --serial S-1 --json
says "['board']" begun
says "['to_finish']" "--only corner"
run 7 "no serial, and the clamp has not opened"
expect_exit 0 "a dry run does not care" "$gantry" dry-run $short --serial S-1 --out "$work/dry"
run 2 "a feature that is not there" --serial S-1 --only cornr
expect_text "did you mean 'corner'?"
run 2 "from and only at once" --from a --only corner
run 0 "what was cut makes it whole" --serial S-1 --only " corner"
expect_text "done: 1 of 1 features"
expect_text "board          whole"
ls "$state"/begun-sim/part*.json 2>/dev/null && fail "it is finished, and remembered"
run 0 "the next board"
end_owner

start_owner --sim-script "$work/stop.yaml"
give_up_when_stopped
run 7 "cut, and no serial"
placed() { grep -o '"placement": "[^"]*"' "$work/job/summary.json"; }
cut_one=$(placed)
reset
run 7 "the part in the machine"
expect_text "the part in the machine was begun"
expect_exit 0 "it is taken out" order part-removed
expect_text "is not waited for any more"
run 0 "another part"
[ "$(placed)" != "$cut_one" ] || fail "the part that was taken out lies there still: $cut_one"
end_owner

start_owner --sim-script "$work/stop.yaml"
give_up_when_stopped
run 7 "cut with the owner's last board" --serial S-9
mkdir -p "$state/begun-ethercat" && cp "$state"/begun-sim/*.json "$state/begun-ethercat"
end_owner
expect_exit 0 "taken out of a machine without owner" order part-removed
expect_text "the part 'S-9' that recipe .* is out of the machine, and still known by its serial: a run with --serial S-9 and --only corner finishes it"
ls "$state"/begun-ethercat/part-*.json >/dev/null || fail "it may be brought back, and is forgotten"
expect_exit 0 "it comes back no more" order part-removed --serial S-9
expect_text "the part 'S-9' that recipe .* is not waited for any more"
ls "$state"/begun-ethercat/part*.json 2>/dev/null && fail "it is remembered still"
expect_exit 0 "nothing is in a machine without owner" order part-removed
expect_text "no part was begun and not finished"
expect_exit 0 "nobody knows this serial" order part-removed --serial nosuch
expect_text "no part with serial 'nosuch' was begun and not finished"
start_owner
run 0 "a new simulated board" --serial S-9
end_owner

# `run` alone makes a new simulated board each time: nothing is remembered, and nothing is refused.
alone() { local code=$1 what=$2; shift 2; expect_exit "$code" "$what" "$gantry" run $short --state "$work/alone" --out "$work/job" --force "$@"; }
alone 7 "cut, alone" --serial S-1 --sim-script "$work/stop.yaml"
[ -e "$work/alone" ] && fail "a state folder was made: $(find "$work/alone")"
alone 0 "again, alone" --serial S-1

# Where the simulated world outlives the program: the power fails while the job runs.
for serial in "" "--serial P-1"; do
  rm -rf "$work/alone" "$work/world"
  # shellcheck disable=SC2086
  "$gantry" run $short --state "$work/alone" --sim-state "$work/world" --out "$work/job" --force $serial >"$work/cut.out" 2>&1 </dev/null &
  job=$!; pids+=($job)
  wait_for 40 ls "$work/alone/begun-sim-kept/in-machine.json" || { fail "nothing is remembered before the job"; cat "$work/cut.out"; }
  sleep 1; kill -9 $job; wait $job 2>/dev/null
  # shellcheck disable=SC2086
  { alone 7 "after a power cut${serial:+, with a serial}" --sim-state "$work/world" $serial
    expect_text "nobody saw how far it came; look at the board and dispense what is missing with --from FEATURE or --only FEATURES"
    alone 7 "what it lacks, after a power cut${serial:+, with a serial}" --sim-state "$work/world" $serial --finish
    expect_text "nobody saw how far it came.*or say .gantry part-removed.* when it is taken out"
    alone 7 "another serial after a power cut${serial:+, with a serial}" --sim-state "$work/world" --serial P-2
    [ -z "$serial" ] || expect_text "the part with serial 'P-1', .* may still be in the machine, and this job is for 'P-2'"
    alone 0 "from its first feature" --sim-state "$work/world" --from a $serial
    expect_text "board          whole"
    alone 0 "the next one" --sim-state "$work/world" ${serial:+--serial P-2}; }
done

# A board that the clamp of a world that is kept holds is there for the next program, begun or finished with a defect.
rm -rf "$work/alone" "$work/world"
kept() { alone "$@" --sim-state "$work/world"; }
kept 7 "a bead is cut by the stop button, alone" --serial P-1 --sim-script "$work/stop.yaml"
kept 7 "another serial over a begun board" --serial P-2
expect_text "the clamp still holds the part with serial 'P-1'"
expect_exit 0 "it is taken out, and no owner is up" "$gantry" part-removed --state "$work/alone"
kept 0 "another serial on another board" --serial P-2
expect_text "board          whole"
kept 7 "a simulated board that was taken out is gone" --serial P-1 --finish
sed -i 's/^sim:$/sim:\n  tip_errors: {needle: [0.3 mm, 0 mm, 0 mm]}/' "$work/config/machines/patient.yaml"
rm -rf "$work/alone" "$work/world"
kept 9 "a needle that is bent" --serial P-1
for serial in "--serial P-1" "" "--serial P-2"; do
  # shellcheck disable=SC2086
  kept 7 "a job over what it left, ${serial:-without serial}" $serial
  expect_text "part-removed"
done
