#!/usr/bin/env bash
# Jogs as people type them: what is no jog, nobody who owns the machine, an owner, and Ctrl-C on the way.
source "$(dirname "$0")/lib.sh"
use_patient_machine
# Axes that stand within 100 ms from higher speeds, so that a jog is soon at the other end.
sed -i -e 's/j_max: 80000 /j_max: 800000 /' -e 's/j_max: 72000 /j_max: 720000 /' "$(sed -n 's/.*--machine "\([^"]*\)".*/\1/p' "$gantry")"
state=$work/state
jog() { "$gantry" jog "$@" --state "$state"; }

expect_exit 0 "help" "$gantry" jog --help
expect_text "gantry jog Z -2mm"
expect_exit 2 "no axis" jog
expect_exit 2 "a distance in two words" jog X 10 mm
expect_text 'in one word: X 10mm'
expect_exit 2 "an axis twice" jog X 1mm X 2mm
expect_exit 2 "a bare number" jog X 10
expect_text "'10' lacks a unit"
expect_exit 2 "an axis that is not there" jog Q 1mm
expect_text "known: X, Y, Z, C, U, F"
expect_exit 4 "an axis that positions by itself" jog F 1mm
expect_text "axis F: it positions by itself"
expect_exit 7 "no owner" jog X 10mm
expect_text "start \`gantry up\`, then \`gantry home\`"

"$gantry" up --state "$state" >"$work/up.out" 2>&1 </dev/null &
owner=$!; pids+=($owner)
wait_for 20 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
expect_exit 7 "axes that are not referenced" jog X 10mm
expect_text "run \`gantry home\` first"
expect_exit 0 "home" "$gantry" home --state "$state"
# went AXIS DISPLACEMENT...: the last jog's document says that these axes went by these displacements
went() {
  python3 - "$work/out" "$@" <<'PY' || fail "not gone by $*"
import json, sys
answer, asked = json.load(open(sys.argv[1])), sys.argv[2:]
gone = {a["name"]: a["end"] - a["start"] for a in answer["axes"]}
assert gone.keys() == set(asked[0::2]), gone
assert all(abs(gone[n] - float(d)) < 1e-9 for n, d in zip(asked[0::2], asked[1::2])), gone
assert answer["ok"] and answer["state"] == "ready" and answer["duration_s"] > 0, answer
PY
}
expect_exit 0 "one axis" jog --json X 10mm
went X 10
expect_exit 0 "down" jog Z -2mm
expect_text "^Z .* -> .* mm, 0\.[0-9]* s$"
expect_exit 0 "three axes, one of which turns" jog --json X 155mm Y "264 mm" C "15 deg" --speed "0.4 m/s"
went X 155 Y 264 C 0.2617993877991494
expect_text '"slowed": "no faster than [0-9.]* mm/s, because axis . would else not stand within 100 ms of its client.s last word"'
expect_exit 4 "a body on the path" jog Z -50mm
expect_text "needle comes within 2 mm of post at (16[0-9]\.[0-9]*, 26[0-9]\.[0-9]*, -62.00) mm"
expect_exit 4 "past a limit" jog X "-1 m"
expect_text "axis X: it would go to .*, past its lower limit 0.000 mm; it stands at .* from there"

"$gantry" jog X 100mm --speed "5 mm/s" --state "$state" >"$work/long" 2>&1 &
long=$!; pids+=($long)
sleep 1
expect_exit 7 "two at once" jog Y 1mm
expect_text "busy"
kill -INT $long; wait $long; code=$?
[ $code = 130 ] && echo "ok: Ctrl-C on the path" || { fail "Ctrl-C gave $code"; cat "$work/long"; }
expect_exit 0 "and on" jog --json X -1mm
went X -1
kill -TERM $owner; wait $owner && echo "ok: the owner ends in order" || fail "the owner did not end in order"
