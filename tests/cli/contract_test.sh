#!/usr/bin/env bash
# Exit codes and words of the program's contract, in virtual time.
source "$(dirname "$0")/lib.sh"
demo=recipes/demo-board.yaml

expect_exit 0 "a dry run of the demo board" "$gantry" --json dry-run $demo --out "$work/a"
python3 -m json.tool "$work/out" >/dev/null 2>&1 || grep -q '"setpoint_hash"' "$work/out" || fail "stdout is no JSON document"
[ -s "$work/a/report.html" ] && [ -s "$work/a/summary.json" ] && [ -s "$work/a/deposits.csv" ] || fail "the job's files are not all there"

sed -e 's/speed: 15 mm\/s/sped: 15 mm\/s/' -e 's/gap: 0.4 mm/gap: 0.4/' -e 's/material: sealant/material: selant/' $demo |
  awk '/material: selant/ && n++ {sub("selant", "sealant")} {print}' >"$work/three.yaml"
expect_exit 3 "three mistakes" "$gantry" check "$work/three.yaml"
# place PATTERN: "line:col" of its first match
place() { grep -n -o -b -m1 -- "$1" "$work/three.yaml" | head -1 | { IFS=: read -r line byte _
  start=$(head -n $((line - 1)) "$work/three.yaml" | wc -c); echo "$line:$((byte - start + 1))"; }; }
count=$(grep -c "$work/three.yaml:[0-9]*:[0-9]*:" "$work/err")
[ "$count" = 3 ] || fail "three mistakes gave $count messages"
expect_text "$work/three.yaml:$(place sped): unknown key 'sped'; did you mean 'speed'"
expect_text "$work/three.yaml:$(place '0\.4$'): '0.4' lacks a unit"
expect_text "$work/three.yaml:$(place selant): there is no material 'selant'; did you mean 'sealant'"
expect_exit 3 "three mistakes, nothing runs" "$gantry" dry-run "$work/three.yaml"

awk '{print} /^fixtures:/ {print "  roof: {at: [36 mm, 34 mm], size: [6 mm, 6 mm, 30 mm]}"}' $demo >"$work/roof.yaml"
expect_exit 4 "an obstacle on the only path" "$gantry" dry-run "$work/roof.yaml" --out "$work/roof"
expect_text "$work/roof.yaml:[0-9]*:5: dot .spreader.*needle comes within 2 mm of roof at (36.00, 34.00, [0-9.]*) mm .machine 216.00, 184.00, "
expect_refusal() {  # FOLDER CODE: a job that never began still tells why
  grep -q "\"exit_code\": $2" "$1/summary.json" && grep -q '"code":"G' "$1/summary.json" && [ -s "$1/report.html" ] ||
    fail "$1 does not tell the refusal"
}
expect_refusal "$work/roof" 4
echo '- {at: cycle 10, do: cut_link, station: y1}' >"$work/cut.yaml"
echo left >"$work/roof/marks"
expect_exit 5 "a bus that is cut in the bring-up" "$gantry" dry-run $demo --sim-script "$work/cut.yaml" --out "$work/roof" --force
expect_refusal "$work/roof" 5
[ "$(cat "$work/roof/marks")" = left ] || fail "a file that no job has left is gone"
expect_exit 2 "a folder that cannot be made" "$gantry" dry-run $demo --out /proc/none
expect_text "/proc/none"

echo '- {at: job start, do: remove_mark, name: back_right}' >"$work/no-mark.yaml"
expect_exit 6 "a mark that is not there" "$gantry" dry-run $demo --sim-script "$work/no-mark.yaml" --out "$work/m"
echo '- {at: feature dot 3, do: drive_fault, axis: X, code: 0x0E}' >"$work/fault.yaml"
expect_exit 5 "a drive fault in mid job" "$gantry" dry-run $demo --sim-script "$work/fault.yaml" --out "$work/f"
expect_text "60 V"
expect_exit 2 "a placement with a mistake" "$gantry" dry-run $demo --sim-board "dx=1.3, dy=1 mm"
expect_exit 2 "an unknown verb" "$gantry" rum
expect_text "there is no 'gantry rum'; did you mean 'run'?"
expect_exit 2 "an unknown verb of a verb" "$gantry" bus fly
expect_text "there is no 'gantry bus fly'; known: scan"
expect_exit 2 "an unknown option" "$gantry" --json dry-run $demo --fast
grep -q '"code": "G901"' "$work/out" || fail "a mistake of usage is no JSON document"
# What remedies tell people to type exists: words in backticks, up to the first option; what holds a colon is a key of a file.
grep -o '`[^`]*`' core/fault_table.def | tr -d '`' | sed -e 's/^gantry //' -e 's, *--.*,,' | grep -v -e '^ip ' -e ':' | sort -u |
  while read -r words; do
    # shellcheck disable=SC2086
    "$gantry" $words --help 2>&1 | grep -q "^Usage: gantry${words:+ $words} " || echo "remedy names '$words'"
  done >"$work/no-verbs"
[ -s "$work/no-verbs" ] && fail "$(cat "$work/no-verbs")"
expect_exit 2 "an unknown bus" "$gantry" run $demo --bus profibus --state "$work/none"
expect_exit 3 "a recipe that is not there" "$gantry" dry-run "$work/nothing.yaml"
expect_exit 2 "a world beside the virtual bus" "$gantry" run $demo --world "$work/world.sock" --state "$work/none"
expect_text "bus ethercat:IFACE"
expect_exit 0 "a code explained" "$gantry" explain G207
expect_text "lag\|follow"
expect_exit 0 "the demo board checked" "$gantry" check $demo
expect_text "sealant: a deposit is good within"
grep -q "bus that is lost" "$work/out" && fail "what a lost bus costs is told without -v"
expect_text "things are assumed"
expect_exit 0 "the demo board checked with -v" "$gantry" -v check $demo
expect_text "sealant: a bus that is lost on a bead costs 2.0 mm"
printf -- '- {at: feature nope, do: camera_dead}\n- {at: job start, do: remove_mark, name: back_rigt}\n' >"$work/never.yaml"
expect_exit 3 "entries of a script that never happen" "$gantry" dry-run $demo --sim-script "$work/never.yaml" --out "$work/n"
expect_text "$work/never.yaml:1:3: this never happens: there is no feature 'nope'"
expect_text "$work/never.yaml:2:3: .*did you mean 'back_right'"
expect_exit 3 "a script on the board of a recipe, checked" "$gantry" check "$work/never.yaml" $demo
expect_text "$work/never.yaml:2:3: .*did you mean 'back_right'"
sed 's/^stations:/statons:/' config/machines/dispenser.yaml >"$work/machine.yaml"
expect_exit 3 "a machine file is checked as one" "$gantry" check "$work/machine.yaml"
expect_text "$work/machine.yaml:[0-9]*:1: unknown key 'statons'; did you mean 'stations'?"
expect_exit 0 "a machine file, a recipe, a profile and a script" "$gantry" check config/machines/dispenser.yaml $demo \
  config/drives/id286.yaml "$work/fault.yaml"
expect_text "$work/fault.yaml: 1 entries"
for wrong in "monitor --for -1" "dry-run $demo --sim-seed -1" "run $demo --world nowhere.sock"; do
  # shellcheck disable=SC2086
  expect_exit 2 "$wrong" "$gantry" $wrong
done
expect_exit 0 "the catalogue as JSON" "$gantry" --json explain
python3 -c 'import json, sys; assert len(json.load(sys.stdin)["faults"]) > 50' <"$work/out" || fail "the catalogue is no JSON"
