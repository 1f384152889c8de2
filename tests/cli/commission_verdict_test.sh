#!/usr/bin/env bash
# `gantry commission` and a start judge alike: what no start would give torque to, a look already ends with.
source "$(dirname "$0")/lib.sh"
name=gcom$$
cable $name
inside() { scripts/veth-pair exec $name -- "$@"; }
sim=$work/sim own=$work/own state=$work/state
mkdir -p "$sim" "$own"
cp -r config recipes "$sim" && cp -r config recipes "$own"
# The stations: y1 without its switches, x and y2 with another current, and z, whose motor may turn slowly.
sed -i -e '/^  y1:/s/, alias: 2//' -e '/^  x:/s/run_current: 4.2 A/run_current: 3 A/' \
  -e '/^  y2:/s/run_current: 4.2 A/run_current: 3 A/' \
  -e '/^  z:/s/profile: id286/profile: slow286/' "$sim/config/machines/dispenser.yaml"
sed -e '/0x6080/s/initial: [0-9]*/initial: 100/' config/drives/id286.yaml >"$sim/config/drives/slow286.yaml"
sed -e '/^  x:/s/profile: id286/profile: amd530b/' -e '/^  x:/s/, parameters: {[^}]*}/, parameters: {run_current: 3 A}/' \
  "$own/config/machines/dispenser.yaml" >"$own/config/machines/another.yaml"
sed -e 's/, alias: [0-9]*//' "$own/config/machines/dispenser.yaml" >"$own/config/machines/alike.yaml"
sed -e '/^  x:/s/run_current: 4.2 A, //' "$own/config/machines/dispenser.yaml" >"$own/config/machines/bare.yaml"
sed -e '/^  cu:/a\  more: {profile: dio16, position: 6}' "$own/config/machines/dispenser.yaml" >"$own/config/machines/longer.yaml"
cmp -s "$sim/config/machines/dispenser.yaml" "$own/config/machines/dispenser.yaml" && fail "nothing was altered"
inside "$gantry" --machine "$sim/config/machines/dispenser.yaml" sim --interface $name-sim --world "$work/world" >"$work/sim.out" 2>&1 </dev/null &
pids+=($!)
wait_for 10 test -S "$work/world" || { fail "no world socket"; cat "$work/sim.out"; }
commission() { # machine, then what is asked
  inside "$gantry" --machine "$own/config/machines/$1.yaml" commission "${@:2}" --interface $name-ctl --state "$state"
}
home() { inside "$gantry" --machine "$own/config/machines/$1.yaml" home --bus ethercat:$name-ctl --state "$state"; }

expect_exit 5 "what is written to a station that nobody has spoken to yet" commission dispenser y2 --write
expect_text "G131"
expect_exit 0 "a station that is as the file says" commission dispenser io
expect_exit 5 "the same, of a file that states no current for another" commission bare io
expect_text "run_current"
expect_exit 3 "a start by that file" home bare
expect_exit 5 "the same, of a file that has a station more than the line" commission longer io
expect_text "6 stations answer, the machine file has 7"
expect_exit 5 "a start by that file" home longer
expect_text "6 stations answer, the machine file has 7"
expect_exit 5 "a station without its alias" commission dispenser y1
expect_text "alias 0 (the machine file says 2)"
expect_text "G108"
expect_exit 5 "the same, for a program" commission dispenser y1 --json
expect_text '"as_expected": false'
expect_text '"exit_code": 5'
expect_exit 5 "a start of it" home dispenser
expect_text "G108"
expect_exit 5 "another device than the file says" commission another x
expect_text "correct the wiring or the order in the machine file"
expect_exit 5 "stations that nothing tells apart" commission alike --all
expect_text "look alike"
expect_exit 5 "a start of them" home alike
expect_text "look alike"
expect_exit 5 "a drive that turns too slowly for its axis" commission dispenser z
expect_text "6080h"
expect_exit 5 "a value that differs" commission dispenser x
expect_text "is 3000 instead of 4200"
expect_exit 5 "the same, for a program" commission dispenser x --json
expect_text '"code": "G130"'
expect_exit 5 "is written, and waits for the supply" commission dispenser x --write
expect_text "G131"
expect_text "at power-up   written"
expect_exit 5 "as a second writing says" commission dispenser x --write
expect_text "G131"
expect_exit 5 "as a later look says, too" commission dispenser x
expect_text "switch its supply off and on"
expect_exit 2 "a station that is not there" commission dispenser foo
expect_text "there is no station or axis 'foo'"
expect_text "known: io, x, y1"
