#!/usr/bin/env bash
# `gantry explain` and the drives' own codes. The judge is what the manuals say (STD402EC 11.5, AMD530B 3.8 and 8.3,
# iD286 3.8.3) and the rows of the profiles, read by another reader.
source "$(dirname "$0")/lib.sh"

expect_exit 0 "a code of the STD402EC" "$gantry" explain std402ec:8611
expect_text "position error too large"
expect_text "check the load and the mechanics"
expect_text "STD402EC manual V1.0 (2024-07-29), section 11.5"
expect_text "becomes: *G200 DriveFault"
cp "$work/out" "$work/first"
for way in STD402EC:0x8611 std402ec:8611h; do
  expect_exit 0 "written as $way" "$gantry" explain "$way"
  cmp -s "$work/out" "$work/first" || fail "$way is told otherwise than std402ec:8611"
done
expect_exit 0 "an emergency stop" "$gantry" explain std402ec:ff23
expect_text "becomes: *G202 "
expect_exit 0 "under-voltage" "$gantry" explain amd530b:3220
expect_text "becomes: *G213 "
expect_exit 0 "a limit" "$gantry" explain id286:800
expect_text "becomes: *G211 "
expect_exit 0 "a warning" "$gantry" explain id286:0100
expect_text "becomes: *G203 "
expect_exit 0 "what only a power cycle clears" "$gantry" explain amd530b:2310
expect_text "power cycle"
expect_exit 0 "a code without a section" "$gantry" explain id286:0064
expect_text "assumed"
expect_exit 0 "a bit of the AMD530B's alarm word" "$gantry" explain amd530b:213F.4
expect_text "positive over-travel"
expect_text "section 8.3"
expect_exit 0 "an alarm bit with a code beside it" "$gantry" explain amd530b:213f.14
expect_text "homing error"
expect_text "becomes: *G200 "

expect_exit 0 "a fault that is not latched" "$gantry" explain G604
expect_text "cleared:  nothing is latched"
expect_exit 0 "a fault that is" "$gantry" explain G200
expect_text "cleared:  by "
expect_exit 0 "all codes of a drive" "$gantry" explain std402ec
[ "$(grep -c '^std402ec:' "$work/out")" = "$(grep -c '{code: 0x' config/drives/std402ec.yaml)" ] || fail "not all codes are listed"
# Every row of every profile, by another reader than the program's.
for file in config/drives/*.yaml; do
  drive=$(basename "$file" .yaml)
  grep -oE '\{code: 0x[0-9A-F]+' "$file" | sed 's/.*0x//' | while read -r code; do
    "$gantry" --json explain "$drive:$code" >"$work/one.json" || echo "$drive:$code: not known"
    text=$(grep "{code: 0x$code," "$file" | sed -e 's/.* text: *\([^,]*\),.*/\1/')
    python3 - "$work/one.json" "$drive:$code" "$text" "$(grep "{code: 0x$code," "$file" | grep -oE 'section: "[^"]*"' | cut -d'"' -f2)" <<'PY'
import json, sys
d = json.load(open(sys.argv[1]))
want = {"code": sys.argv[2], "text": sys.argv[3], "section": sys.argv[4] or None, "assumed": not sys.argv[4]}
for key, value in want.items():
    if d[key] != value:
        print(f"{sys.argv[2]}: {key} is {d[key]!r}, the profile has {value!r}")
if not d["remedy"] or not d["becomes"]["code"].startswith("G2"):
    print(f"{sys.argv[2]}: no remedy, or no fault of ours")
PY
  done
done >"$work/wrong"
[ -s "$work/wrong" ] && fail "$(cat "$work/wrong")"

expect_exit 2 "a drive that nobody knows" "$gantry" explain std402:8611
expect_text "there is no drive 'std402' in .*config/drives; did you mean 'std402ec'?"
expect_exit 2 "a code that the manual does not list" "$gantry" explain std402ec:8612
expect_text "did you mean '8611'?"
expect_exit 2 "the same as JSON" "$gantry" --json explain std402ec:8612
python3 -c 'import json, sys; assert json.load(sys.stdin)["errors"][0]["code"] == "G901"' <"$work/out" || fail "no JSON"
expect_exit 2 "a fault that nobody knows" "$gantry" explain FolowingError
expect_text "did you mean 'FollowingError'?"
expect_exit 2 "a number that nobody knows" "$gantry" explain G999
