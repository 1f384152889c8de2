#!/usr/bin/env bash
# What a monitor hears of a whole machine: a job that is held and resumed, one that is aborted, and an emergency stop of an
# idle machine. Judged by the monitor's lines alone.
source "$(dirname "$0")/lib.sh"
use_patient_machine
state=$work/state domain=$((100 + $$ % 100))
order() { "$gantry" "$@" --state "$state" >/dev/null 2>&1 </dev/null; }
status_has() { "$gantry" --json status --state "$state" 2>/dev/null | grep -q "$1"; }
owner=''
up() {
  "$gantry" up --state "$state" --domain $domain "$@" >"$work/up.out" 2>&1 </dev/null &
  owner=$!; pids+=($owner)
  wait_for 40 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
}
listen() { # FILE
  "$gantry" --json monitor --domain $domain --for 200 >"$1" 2>"$work/monitor.err" </dev/null &
  listener=$!; pids+=($listener)
  wait_for 20 test -s "$1" || { fail "nothing is heard"; cat "$work/monitor.err"; }
}

up
listen "$work/lines"
"$gantry" run tests/cli/short-board.yaml --state "$state" --serial A17 --out "$work/job" >"$work/job.out" 2>&1 </dev/null &
job=$!; pids+=($job)
wait_for 60 status_has '"doing": "dispensing"' || fail "the job does not dispense"
wait_for 5 order hold --now || fail "it takes no hold"
wait_for 10 status_has '"state": "held"' || fail "it is not held"
sleep 2
order resume || fail "it takes no resume"
wait $job
[ "$(grep -c '"result"' "$work/job/summary.json")" = 1 ] || { fail "the job left no result"; cat "$work/job.out"; }
"$gantry" run tests/cli/short-board.yaml --state "$state" --serial A18 --out "$work/aborted" >"$work/job.out" 2>&1 </dev/null &
job=$!; pids+=($job)
wait_for 60 status_has '"doing": "mark' || fail "the second job does not look at a mark"
order abort || fail "it takes no abort"
wait $job
sleep 1
kill $listener; wait $listener
order down; wait $owner
python3 - "$work/lines" "$work/job/summary.json" <<'PY' || fail "what was heard of two jobs"
import itertools, json, sys
lines = [json.loads(l) for l in open(sys.argv[1])]
summary = json.load(open(sys.argv[2]))
assert lines[0]["complete"] is True, "the first line"
samples = {}
for line in lines:
    if line["job"]: samples[line["job"]["time_ns"]] = line["job"]
samples = [samples[t] for t in sorted(samples)]
over = ("done", "done_with_defects", "failed", "aborted", "interrupted")
def words(job): return [w for w, _ in itertools.groupby(s["state"] for s in job)]
first = [s for s in samples if s["job"] == "job"]
second = [s for s in samples if s["job"] == "aborted"]
print("states:", words(first), words(second))
assert words(first) == ["running", "held", "running", summary["result"]], words(first)
assert words(second) == ["running", "aborted"], words(second)
for job in first, second:
    works = [s for s in job if s["state"] not in over]
    clock = [s["elapsed_s"] for s in works]
    assert clock[0] < 1, f"heard of after {clock[0]} s"
    assert all(b > a for a, b in zip(clock, clock[1:])), "the clock stands or goes back"
    assert len({s["predicted_s"] for s in job}) == 1 and job[0]["predicted_s"] > 3, "the prediction changes"
    # The first that is heard may be of its first motion: nothing is played before it, and no second counts twice.
    begins = job[0]["predicted_s"] - job[0]["remaining_s"]
    assert job[-1]["remaining_s"] == 0 and 0 <= begins <= job[0]["elapsed_s"], (begins, job[0]["elapsed_s"])
clock = [s["elapsed_s"] for s in first if s["state"] not in over]
steps = sorted(b - a for a, b in zip(clock, clock[1:]))
print(f"{len(clock)} samples in {clock[-1]:.1f} s, the longest step {steps[-1]:.3f} s")
assert len(clock) >= 2 * (clock[-1] - clock[0]), "fewer than two a second"
held = [s["elapsed_s"] for s in first if s["state"] == "held"]
assert held[-1] - held[0] > 1.4 and len(held) >= 3, held
end_s = first[-1]["elapsed_s"]
resumed_s = next(s["elapsed_s"] for s in reversed(first) if s["state"] == "held")
errors = [s["remaining_s"] - (end_s - s["elapsed_s"]) for s in first if s["state"] == "running" and s["elapsed_s"] > resumed_s]
print(f"what is left, as told after the resume: {min(errors):+.2f} to {max(errors):+.2f} s of the truth")
assert all(abs(e) < 2.5 for e in errors), errors
done = [s["features_done"] for s in first]
assert done == sorted(done) and done[0] == 0 and done[-1] == summary["counts"]["features_done"], done
events = [e for line in lines for e in line["events"]]
told = [(e["kind"], e["text"]) for e in events if e["kind"] in ("action", "part")]
for text in told: print("   ", *text)
def index(kind, part): return next(i for i, t in enumerate(told) if t[0] == kind and part in t[1])
at = [index("part", "job, part A17 begins"), index("action", "hold"), index("action", "resume"),
      index("part", "job, part A17: " + summary["result"] + "; board: " + summary["board"]),
      index("part", "aborted, part A18 begins"), index("action", "abort"), index("part", "aborted, part A18: aborted; board: untouched")]
assert at == sorted(at), at
assert [e["seq"] for e in events] == list(range(events[0]["seq"], events[0]["seq"] + len(events))), "events have holes"
PY

printf -- '- {at: cycle 4000, do: emergency_stop}\n- {at: cycle 9000, do: emergency_release}\n' >"$work/script.yaml"
rm -rf "$state"
up --sim-script "$work/script.yaml"
listen "$work/alarms"
wait_for 20 grep -q '"alarms":\[{' "$work/alarms" || fail "no alarm"
"$gantry" --json monitor --domain $domain --count 1 --for 20 >"$work/late" 2>/dev/null </dev/null
sleep 5
for _ in 1 2 3 4 5; do order reset && break; sleep 1; done
wait_for 10 sh -c "tail -1 '$work/alarms' | grep -q '\"alarms\":\[\]'" || fail "the alarm does not go"
kill $listener; wait $listener
order down; wait $owner
python3 - "$work/late" "$work/alarms" <<'PY' || fail "what was heard of the emergency stop"
import json, sys
late = json.loads(open(sys.argv[1]).readline())
assert late["complete"] is True
alarms = {a["code"]: a for a in late["alarms"]}
print("   ", sorted(alarms))
stop = alarms["G712"]
assert stop["text"] and stop["remedy"] and stop["since_ns"] <= late["time_ns"], stop
lines = [json.loads(l) for l in open(sys.argv[2])]
since = {a["since_ns"] for l in lines for a in l["alarms"] if a["code"] == "G712"}
assert len(since) == 1, "since when is not one time"
words = [bool(l["alarms"]) for l in lines]
assert words[-1] is False and True in words
assert any(e["kind"] == "action" and e["text"] == "reset" for l in lines for e in l["events"])
PY
