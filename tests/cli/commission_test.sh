#!/usr/bin/env bash
# Commissioning as people do it, on the simulated machine: looking, and the walk with its answers.
source "$(dirname "$0")/lib.sh"
state=$work/state
kept=$state/accepted-sim.json
commission() { "$gantry" commission "$@" --state "$state"; }
answers() { printf '%s\n' "$@" >"$work/answers"; }
walk() { commission --walk "$@" <"$work/answers"; }

expect_exit 0 "a look" commission --all
expect_text "homing_slow  *6099h:2"; expect_text "homing_slow  *6899h:2"  # what homing sets is named by G130, too
[ ! -e "$kept" ] || fail "a look has left $kept"
expect_exit 2 "a walk of one station" commission --walk x
expect_exit 2 "a walk that accepts besides" commission --walk --accept

answers ""
expect_exit 7 "answers that end" walk
expect_text "the answers have ended"
answers "no"
expect_exit 7 "somebody who does not want it" walk
expect_text "Enter alone"
answers "" "Z-"
expect_exit 5 "an axis that goes the other way" walk
expect_text "G133"
expect_text "parameters.direction"
answers "" "Z+" "" "X+"
expect_exit 5 "another axis than was ordered" walk
expect_text "U was ordered, and X moved"
answers "" "Z+" "" "what?" "nothing"
expect_exit 5 "an axis that does not move" walk
expect_text "write the axis that moved"
expect_text "nothing moved: look at the supply"
[ ! -e "$kept" ] || fail "wrong answers were kept"

answers "" "Z+" "" "u -" "" "X+" "" "Y+" "" "C+"
expect_exit 0 "all as the machine file says" walk --json
expect_text "Z by +0.5 mm and back"
expect_text "C by +3 deg and back"
python3 - "$work/out" "$kept" <<'PY' || fail "not kept as it was walked"
import json, sys
said, kept = (json.load(open(f)) for f in sys.argv[1:])
assert said["result"] == "done" and said["axes"] == ["Z", "U", "X", "Y", "C"], said
rows = kept["stations"]
assert all(rows[s]["walked"] == said["date"] for s in ("x", "y1", "y2", "z", "cu")), rows
assert "io" not in rows, rows
PY
answers "" "Z-"
expect_exit 5 "a later walk that finds otherwise" walk
python3 -c 'import json, sys; assert all(r["walked"] == "" for r in json.load(open(sys.argv[1]))["stations"].values())' "$kept" ||
  fail "an earlier walk still counts"
