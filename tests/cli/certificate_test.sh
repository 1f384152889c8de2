#!/usr/bin/env bash
# A certificate, as its operator sees it: a dry run writes it, a run demands it, alone and through an owner.
source "$(dirname "$0")/lib.sh"
use_patient_machine
cp tests/cli/short-board.yaml "$work/board.yaml"
board=$work/board.yaml
machine=$work/config/machines/patient.yaml
certificate=$work/dry/certificate.json
key() { python3 -c 'import json, sys; print(eval("json.load(open(sys.argv[1]))" + sys.argv[2]))' "$certificate" "$1"; }
demand() { local code=$1 what=$2; shift 2; expect_exit "$code" "$what" "$gantry" run "$board" --certificate "$certificate" --out "$work/job" --force "$@"; }
refused() { # WHAT HASH FILE OLD NEW
  grep -q -- "$4" "$3" || fail "$1: no '$4' in $3"
  cp "$3" "$work/kept"
  sed -i "s|$4|$5|" "$3"
  rm -rf "$work/job"
  demand 7 "$1"
  expect_text "G702"
  expect_text "$2 (certified [0-9a-f]*, loaded [0-9a-f]*)"
  expect_text "gantry dry-run .*board.yaml"
  [ -e "$work/job" ] && fail "$1: a job's folder was made"
  cp "$work/kept" "$3"
}

expect_exit 0 "a dry run" "$gantry" dry-run "$board" --out "$work/dry"
[ -s "$certificate" ] || fail "no certificate"
grep -q '"certificate.json"' "$work/dry/summary.json" || fail "the summary does not name the certificate"
[ "$(key "['recipe_file']")" = "$board" ] && [ "$(key "['machine_file']")" = "$machine" ] || fail "the files are not named"
[ "$(key "['motions_certified']")" -gt 10 ] || fail "no motions"
list=$work/dry/motions.csv
echo "$(key "['motions']['sha256']")  $list" | sha256sum -c --quiet || fail "the list of motions has another hash"
[ "$(tail -n +2 "$list" | wc -l)" = "$(key "['motions_certified']")" ] || fail "a row a motion: $(wc -l <"$list")"
[ "$(key "['motions']['count']")" = "$(key "['motions_certified']")" ] || fail "the list has another count"
cp "$certificate" "$work/first.json"
expect_exit 0 "another dry run" "$gantry" dry-run "$board" --out "$work/dry" --force --sim-board "dx=1 mm"
[ "$(key "['hashes']")" = "$(certificate=$work/first.json; key "['hashes']")" ] || fail "other hashes of the same job"

refused "another part of the recipe" recipe "$board" "at: \[15 mm, 10 mm\]" "at: [15.001 mm, 10 mm]"
refused "another limit" limits "$machine" "v_max: 150 mm/s" "v_max: 140 mm/s"
refused "another clearance" limits "$machine" "^clearance: 2 mm" "clearance: 2.1 mm"
refused "another body that stands" scene "$machine" "diameter: 16 mm, height: 60 mm" "diameter: 16.1 mm, height: 60 mm"
refused "another body of the head" head "$machine" "diameter: 26 mm, height: 70 mm" "diameter: 26.1 mm, height: 70 mm"
refused "another needle" calibration "$machine" "tip: \[0 mm, 0 mm, -40 mm\]" "tip: [0.1 mm, 0 mm, -40 mm]"
demand 2 "a feature that is not there" --only nothing
printf '{"format": 1,\n "hashes": 3}\n' >"$work/wrong.json"
expect_exit 3 "a file that is none" "$gantry" run "$board" --certificate "$work/wrong.json"
expect_text "wrong.json:2:12: 'hashes' has to be an object"
expect_exit 3 "a file that is not there" "$gantry" run "$board" --certificate "$work/nowhere.json"
expect_exit 2 "an empty name" "$gantry" run "$board" --certificate ""
expect_exit 3 "a device" "$gantry" run "$board" --certificate /dev/zero
head -c 2000000 /dev/zero | tr '\0' ' ' >"$work/large.json"
expect_exit 3 "a file that is too large" "$gantry" run "$board" --certificate "$work/large.json"
demand 0 "the same job"

# What the file says in other words is the same.
python3 - "$board" <<'PY'
import sys
blocks = []
for line in open(sys.argv[1]):
    if line.startswith("#"): continue
    if line[0] not in " \n": blocks.append("")
    if blocks: blocks[-1] += line
text = "".join(reversed(blocks)).replace("retract: 3 mm", "retract: 0.003 m")
open(sys.argv[1], "w").write("# turned round\n" + text)
PY
mv "$board" "$work/renamed.yaml"; board=$work/renamed.yaml
demand 0 "the same job in another order, elsewhere"

state=$work/state
"$gantry" up --state "$state" >"$work/up.out" 2>&1 </dev/null &
pids+=($!)
wait_for 40 grep -q "is up" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
demand 0 "the same job by an owner" --state "$state"
sed -i "s|window: 1.5 mm|window: 1.4 mm|" "$board"
pushd "$work/dry" >/dev/null || exit 1
expect_exit 7 "another recipe by an owner" "$gantry" run "$board" --certificate certificate.json --state "$state" --json
popd >/dev/null || exit 1
expect_text "recipe (certified"
grep -q '"exit_code": 7' "$work/out" && grep -q '"board": "untouched"' "$work/out" || fail "the answer is not a refusal's"
expect_exit 3 "no file, by an owner" "$gantry" run "$board" --certificate "$work/nowhere.json" --state "$state"
expect_exit 0 "down" "$gantry" down --state "$state"

# One that was proved before does not stand beside a job that failed.
expect_exit 6 "a mark that is not there" "$gantry" dry-run "$board" --out "$work/dry" --force --sim-board "dx=20 mm"
[ -e "$certificate" ] && fail "a certificate of a job that failed"
[ -e "$list" ] && fail "the list of its motions"
exit 0
