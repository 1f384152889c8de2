#!/usr/bin/env bash
# A job that says "done" is done, and a check tells what a start would tell; in virtual time.
source "$(dirname "$0")/lib.sh"
demo=recipes/demo-board.yaml
# key FOLDER KEY: of its summary.json, as JSON
key() { python3 -c 'import json, sys; print(json.dumps(json.load(open(sys.argv[1] + "/summary.json"))[sys.argv[2]]))' "$@"; }
expect_key() { local got; got=$(key "$1" "$2"); [ "$got" = "$3" ] && echo "ok: $2 $3" || fail "$1: $2 is $got, expected $3"; }

expect_exit 0 "a whole board" "$gantry" dry-run $demo --out "$work/whole" --serial S-4711
head -1 "$work/out" | grep -q "^VIRTUAL: done: 35 of 35 features" || fail "the first line is '$(head -1 "$work/out")'"
for pair in 'result:"done"' 'board:"whole"' 'defects:[]' 'bus:"VIRTUAL"' 'serial:"S-4711"' \
  "recipe_sha256:\"$(sha256sum $demo | cut -d' ' -f1)\"" \
  "machine_sha256:\"$(sha256sum config/machines/dispenser.yaml | cut -d' ' -f1)\""; do
  expect_key "$work/whole" "${pair%%:*}" "${pair#*:}"
done
# The profiles that the machine file names, each once.
python3 - "$work/whole" <<'PY' || fail "profiles: $(key "$work/whole" profiles)"
import hashlib, json, re, sys
rows = json.load(open(sys.argv[1] + "/summary.json"))["profiles"]
named = set(re.findall(r"profile: (\w+)", open("config/machines/dispenser.yaml").read()))
assert {re.sub(r".*/|\.yaml$", "", r["file"]) for r in rows} == named and len(rows) == len(named), named
for r in rows:
    assert hashlib.sha256(open(r["file"], "rb").read()).hexdigest() == r["sha256"], r
    kept = sys.argv[1] + "/inputs/" + r["file"].rsplit("/", 1)[1]
    assert open(kept, "rb").read() == open(r["file"], "rb").read(), kept
PY
python3 - "$work/whole/summary.json" <<'PY' || fail "docs/monitoring.md does not name every key of a summary"
import json, re, sys
named = set(re.findall(r"\w+", " ".join(re.findall(r"`([^`]*)`", open("docs/monitoring.md").read()))))
def keys(value):
    for each in value.values() if isinstance(value, dict) else value if isinstance(value, list) else []:
        yield from keys(each)
    if isinstance(value, dict):
        yield from value
summary = json.load(open(sys.argv[1]))
axes = set(summary["max_following_error"])
others = {k for k in summary if k in ("environment",)}
missing = {k for name, value in summary.items() if name not in others for k in [name, *keys(value)]} - named - axes
assert not missing, sorted(missing)
PY
key "$work/whole" program | grep -q '"version": "[0-9.]*", "commit": "[0-9a-f]' || fail "no program in the summary"

# Held in the middle of the first bead, and resumed by the start button.
printf -- '- {at: feature bead 1, after: 500 ms, do: press, input: hold, hold: 100 ms}\n- {at: feature bead 1, after: 2 s, do: press, input: start, hold: 100 ms}\n' >"$work/hold.yaml"
expect_exit 0 "a bead that a hold has cut" "$gantry" dry-run $demo --sim-script "$work/hold.yaml" --out "$work/joined"
expect_key "$work/joined" board '"whole"'
key "$work/joined" joined | grep -q '^\[{"feature": "transformer_dam", "at_mm": [0-9.]*, "after_s": [0-9.]*}\]$' ||
  fail "joined: $(key "$work/joined" joined)"
grep -q "Beads that a hold has cut" "$work/joined/report.html" || fail "the report does not say so"
sed 's/^    retract: .*/&\n    rejoin_within: 500 ms/' $demo >"$work/short-lived.yaml"
expect_exit 9 "a bead that was cut too long ago" "$gantry" dry-run "$work/short-lived.yaml" --sim-script "$work/hold.yaml" --out "$work/held"
expect_text "VIRTUAL: done_with_defects"
expect_text "'transformer_dam': cut by a stop"
expect_key "$work/held" result '"done_with_defects"'
expect_key "$work/held" exit_code 9
expect_key "$work/held" board '"begun"'
key "$work/held" defects | grep -q '^\[{"feature": "transformer_dam", "kind": "cut", "message": "[^"]*"}\]$' ||
  fail "defects: $(key "$work/held" defects)"
grep -q "Done with defects" "$work/held/report.html" || fail "the report's headline does not say so"
key "$work/held" actions | grep -q '"utc": "20[0-9-]*T[0-9:.]*Z", "t_s": [0-9.]*, "what": "button hold"}.*"what": "button start"' ||
  fail "actions: $(key "$work/held" actions)"

# Held for good: nobody presses a button in a dry run but its script, and its time would never end. It ends where nothing
# is left that could resume it, and after ten minutes of the machine in any case.
held_for_good() {  # WHAT SCRIPT SECONDS
  printf -- "$2" >"$work/for-good.yaml"
  expect_exit 3 "$1" timeout 250 "$gantry" dry-run $demo --sim-script "$work/for-good.yaml" --out "$work/good" --force
  expect_text "$work/for-good.yaml:1:3: the dry run stands on hold by 'press at .*', and nobody resumes it"
  expect_text "presses start"
  python3 -c 'import json, sys; n = json.load(open(sys.argv[1]))["setpoint_ticks"]; assert n < float(sys.argv[2]) * 1000, n' \
    "$work/good/summary.json" "$3" || fail "$1: too late"
}
hold_at() { echo "- {at: $1, after: ${2:-500} ms, do: press, input: hold, hold: 100 ms}\n"; }
held_for_good "a hold that nobody resumes" "$(hold_at 'feature bead 1')" 40
expect_key "$work/good" board '"begun"'
held_for_good "a hold while an image is waited for" "$(hold_at 'mark front_left' 5)" 20
expect_key "$work/good" board '"untouched"'
held_for_good "a hold, and a start that waits for a feature behind it" \
  "$(hold_at 'feature bead 1')- {at: feature bead 3, do: press, input: start, hold: 100 ms}\n" 40
held_for_good "a hold, and a start in a hundred days" \
  "$(hold_at 'feature bead 1')- {at: cycle 8640000000, do: press, input: start, hold: 100 ms}\n" 680

# Held on the way from the parts' last dot to the first bead: nothing is open, nothing is cut.
printf -- '- {at: feature anchor_right, after: 75 ms, do: press, input: hold, hold: 100 ms}\n- {at: feature anchor_right, after: 2 s, do: press, input: start, hold: 100 ms}\n' >"$work/travel.yaml"
expect_exit 0 "a hold in travel" "$gantry" dry-run $demo --sim-script "$work/travel.yaml" --out "$work/travelled"
key "$work/travelled" actions | grep -q "button hold" || fail "the hold was not taken"

echo '- {at: feature dot 3, do: drive_fault, axis: X, code: 0x0E}' >"$work/fault.yaml"
expect_exit 5 "an error's own code wins" "$gantry" dry-run $demo --sim-script "$work/fault.yaml" --out "$work/fault"
expect_key "$work/fault" board '"begun"'
key "$work/fault" defects | grep -q '"kind": "missing"' || fail "defects are not listed beside an error"
key "$work/fault" alarms | grep -q '"code": "G200"' || fail "alarms: $(key "$work/fault" alarms)"
echo '- {at: job start, do: remove_mark, name: back_right}' >"$work/no-mark.yaml"
expect_exit 6 "a job that ends before its first shot" "$gantry" dry-run $demo --sim-script "$work/no-mark.yaml" --out "$work/m"
expect_key "$work/m" board '"untouched"'

# Whatever refuses a job, its document says how the board is left.
says_untouched() {
  python3 -c 'import json, sys; d = json.load(open(sys.argv[1])); assert d["board"] == "untouched" and d["errors"] and d["exit_code"] == int(sys.argv[2]), d' \
    "$work/out" "$1" || fail "no \"board\": \"untouched\" in: $(head -c 300 "$work/out")"
}
sed 's/^stations:/statons:/' config/machines/dispenser.yaml >"$work/machine.yaml"
sed 's/frame: pallet/frame: palett/' $demo >"$work/palett.yaml"
printf 'version: 1\nrecipe: "a\xff' >"$work/bytes.yaml"
for verb in "dry-run" "run --state $work/nobody" "run"; do
  # shellcheck disable=SC2086
  { expect_exit 3 "$verb with a wrong machine file" "$gantry" --json --machine "$work/machine.yaml" $verb $demo; says_untouched 3
    expect_exit 3 "$verb without one" "$gantry" --json --machine "$work/none.yaml" $verb $demo; says_untouched 3
    expect_exit 3 "$verb with a wrong recipe" "$gantry" --json $verb "$work/palett.yaml"; says_untouched 3
    expect_exit 3 "$verb without one" "$gantry" --json $verb "$work/nothing.yaml"; says_untouched 3
    expect_exit 3 "$verb with what is no text" "$gantry" --json $verb "$work/bytes.yaml"; says_untouched 3
    expect_exit 2 "$verb and no folder" "$gantry" --json $verb $demo --out /proc/none; says_untouched 2
    expect_exit 2 "$verb with an unknown option" "$gantry" --json $verb $demo --fast; says_untouched 2
    expect_exit 2 "$verb of nothing" "$gantry" --json $verb; says_untouched 2; }
done
expect_exit 2 "run with a bus that is none" "$gantry" --json run $demo --bus profibus --state "$work/nobody"
says_untouched 2
expect_exit 2 "run without a home" env -u HOME -u XDG_STATE_HOME -u GANTRY_STATE "$gantry" --json run $demo
says_untouched 2

# No reference: nobody knows where the board lay, unless a fixture holds it.
sed -e '/^marks:/,/^mark_rules/d' $demo >"$work/unmarked.yaml"
expect_exit 9 "no marks" "$gantry" dry-run "$work/unmarked.yaml" --sim-board "dx=0 mm" --out "$work/u"
expect_text "nothing said where the board lay"
expect_key "$work/u" board '"defects"'
sed -e 's/^board:/placement: fixture\nboard:/' "$work/unmarked.yaml" >"$work/fixture.yaml"
expect_exit 0 "no marks, and a fixture" "$gantry" dry-run "$work/fixture.yaml" --sim-board "dx=0 mm" --out "$work/x"
expect_exit 9 "a fixture that does not hold" "$gantry" dry-run "$work/fixture.yaml" --sim-board "dx=1.5 mm" --out "$work/y"
expect_text "1.5[0-9]* mm beside its place; 0.1 mm are allowed"

# What `check` says, a start says too, before anything moves.
refused() {  # CODE WHAT FILE TEXT
  local verb
  for verb in check dry-run run; do
    expect_exit "$1" "$2: $verb" "$gantry" $verb "$3" $([ $verb = check ] || echo "--out $work/none") \
      $([ $verb = run ] && echo "--state $work/nobody")
    expect_text "$4"
  done
  [ ! -e "$work/none/summary.json" ] || grep -q '"board": "untouched"' "$work/none/summary.json" || fail "$2: begun"
}
expect_exit 0 "the demo board checked and proved" "$gantry" check $demo
expect_text "motions proved free"
expect_text "sealant: a deposit is good within 0.1 mm of its place"
sed -e 's/at: \[5 mm, 66 mm\]/at: [5 mm, 75 mm]/' $demo >"$work/turned.yaml"
refused 3 "a board that may be put in backwards" "$work/turned.yaml" "$work/turned.yaml:[0-9]*:3: a board that lies turned by 180 deg"
sed -e 's/^mark_rules: {/&symmetric: allowed, /' "$work/turned.yaml" >"$work/allowed.yaml"
expect_exit 0 "the same, allowed" "$gantry" check "$work/allowed.yaml"
sed -e 's/size: \[120 mm, 80 mm\]/size: [240 mm, 80 mm]/' $demo >"$work/large.yaml"
refused 3 "a board larger than the pallet" "$work/large.yaml" "does not fit on 'pallet_plate'"
sed -e 's/anchor_left,  material: adhesive, at: \[50 mm, 58 mm\]/anchor_left,  material: adhesive, at: [64 mm, 24 mm]/' $demo >"$work/inside.yaml"
refused 3 "a dot in a part" "$work/inside.yaml" "dot 'anchor_left' goes through part 'relay'"
sed -e 's/clamp_margin: 3 mm/clamp_margin: 11.5 mm/' $demo >"$work/margin.yaml"
refused 3 "work in the clamp's margin" "$work/margin.yaml" "'clamp_margin' keeps for the fixture"
awk '{print} /^fixtures:/ {print "  roof: {at: [36 mm, 34 mm], size: [6 mm, 6 mm, 30 mm]}"}' $demo >"$work/roof.yaml"
expect_exit 4 "a collision is found by check" "$gantry" check "$work/roof.yaml"
expect_text "needle comes within 2 mm of roof"
expect_exit 4 "a portal that is closed on all sides" "$gantry" dry-run recipes/portal-closed.yaml --out "$work/closed"
expect_text "bridge"
expect_key "$work/closed" board '"untouched"'
[ ! -e "$work/closed/setpoints.bin" ] || fail "something was sent to the drives"
expect_exit 0 "a portal that is gone around" "$gantry" dry-run recipes/portal.yaml --out "$work/portal"
expect_key "$work/portal" board '"whole"'
sed -e 's/frame: pallet/frame: palett/' -e '0,/material: sealant/s//material: selant/' -e 's/speed: 20 mm/speed: 900 mm/' $demo >"$work/many.yaml"
expect_exit 3 "mistakes of recipe and machine at once" "$gantry" check "$work/many.yaml"
for each in palett selant "900 mm/s"; do expect_text "$each"; done
"$gantry" --version | grep -qE '^gantry [0-9.]+ \([0-9a-f]{12}' || fail "--version names no commit: $("$gantry" --version)"

# A rival is no mark that is missing: its own code and remedy.
echo '- {at: job start, do: stain, name: front_left, by: [2.5 mm, 1 mm], diameter: 1.5 mm, grey: 230}' >"$work/rival.yaml"
expect_exit 6 "a mark with a rival" "$gantry" dry-run $demo --sim-script "$work/rival.yaml" --out "$work/rival"
expect_text "G601"
expect_text "remedy: .*decoy"
key "$work/rival" errors | grep -q '"code": "G601", "name": "MarkAmbiguous"' || fail "errors: $(key "$work/rival" errors)"

# Two marks: nothing but their distance shows that they are the right ones.
expect_key "$work/whole" trust '"residuals"'
sed '/^marks:/,/^mark_rules/{/front_/d}' $demo >"$work/two.yaml"
"$gantry" dry-run "$work/two.yaml" --out "$work/two" >"$work/out" 2>"$work/err"
expect_key "$work/two" trust '"length only"'
grep -q "Trust: length only" "$work/two/report.html" || fail "the report does not say what two marks are worth"

# What the job was made of lies beside its result.
cmp "$work/whole/inputs/demo-board.yaml" $demo && cmp "$work/whole/inputs/dispenser.yaml" config/machines/dispenser.yaml ||
  fail "the recipe or the machine file is not in the job's folder"

# Too fast for its curve: `check` says so, and so does the job.
cat >"$work/tight.yaml" <<'YAML'
version: 1
recipe: tight
placement: fixture
board: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}
materials:
  fast: {speed: 100 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 300 ms, retract: 3 mm}
features:
  - circle: {name: tight, material: fast, centre: [30 mm, 40 mm], radius: 3 mm}
YAML
"$gantry" check "$work/tight.yaml" >"$work/out" 2>"$work/err"
expect_text "tight.yaml:[0-9:]*: bead 'tight' planned at [0-9.]* mm/s instead of 100 mm/s: .*radius 3 mm.*flow_follows_speed"
expect_exit 9 "a bead that is too fast for its curve" "$gantry" dry-run "$work/tight.yaml" --sim-board "dx=0 mm" --out "$work/tight"
expect_text "'tight': planned at [0-9.]* mm/s instead of 100 mm/s"
expect_key "$work/tight" board '"defects"'
