#!/usr/bin/env bash
# How errors read: what is missing is told with the folders that were looked at, what is misspelt with what was meant.
source "$(dirname "$0")/lib.sh"
demo=recipes/demo-board.yaml

expect_exit 2 "a misspelt option" "$gantry" dry-run $demo --sim-bord "dx=1 mm"
expect_text "there is no option '--sim-bord'; did you mean '--sim-board'?"
expect_exit 2 "a word for the options of help" "$gantry" help
expect_text "there is no 'gantry help'; write .gantry --help."
expect_exit 2 "a misspelt option with its value behind =" "$gantry" dry-run $demo "--sim-sed=4"
expect_text "there is no option '--sim-sed'; did you mean '--sim-seed'?"
expect_exit 2 "a misspelt option before the recipe" "$gantry" run --machin other.yaml $demo
expect_text "there is no option '--machin'; did you mean '--machine'?"
expect_exit 2 "a misspelt option of the program" "$gantry" --jsn check $demo
expect_text "there is no option '--jsn'; did you mean '--json'?"
expect_exit 2 "an option that is like none" "$gantry" dry-run $demo --zzzzzzzzzzzz
expect_text "gantry dry-run --help"
expect_exit 2 "a misspelt option as JSON" "$gantry" --json dry-run $demo --sim-bord "dx=1 mm"
python3 -c 'import json, sys
e = json.load(sys.stdin)
assert e["exit_code"] == 2 and "--sim-board" in e["errors"][0]["message"]' <"$work/out" || fail "no JSON"
# A misspelt verb is the mistake, and not the options that it would have had.
expect_exit 2 "a misspelt verb with its options" "$gantry" dry-rn $demo --sim-board "dx=1 mm"
expect_text "there is no 'gantry dry-rn'; did you mean 'dry-run'?"
expect_exit 2 "a misspelt verb of a verb with its options" "$gantry" bus scann --interface lo
expect_text "there is no 'gantry bus scann'; did you mean 'scan'?"
expect_exit 2 "no recipe" "$gantry" dry-run
expect_text "RECIPE"
expect_exit 2 "a seed that is no number" "$gantry" dry-run $demo --sim-seed -1
[ "$(wc -c <"$work/err")" -lt 300 ] || fail "the message is $(wc -c <"$work/err") bytes long"
# Whatever verb: a misspelt option is exit 2 and moves nothing.
"$gantry" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p' >"$work/verbs"
[ "$(wc -l <"$work/verbs")" -gt 20 ] || fail "the verbs cannot be read from the help"
while read -r verb; do
  "$gantry" "$verb" --jsen >"$work/out" 2>"$work/err" </dev/null
  [ $? = 2 ] || fail "gantry $verb --jsen: another exit code than 2"
done <"$work/verbs"

expect_exit 3 "a machine file that is not there" "$gantry" --machine dispensr.yaml check
expect_text "there is no machine file 'dispensr.yaml'; looked for in $PWD and .*/config/machines; did you mean 'dispenser.yaml'?"
for word in dispenserr Dispensr dispenser.yml dispenserr.yaml config/machines/dispensr; do
  for verb in check "dry-run $demo --out $work/no-machine" "run $demo --state $work/nobody --out $work/no-machine"; do
    expect_exit 3 "--machine $word ${verb%% *}" "$gantry" --machine "$word" $verb
    case $word in *.y*) meant=dispenser.yaml ;; config/*) meant=dispenser.yaml ;; *) meant=dispenser ;; esac
    expect_text "there is no machine file '$(basename "$word")'; looked for in .*; did you mean '$meant'?"
  done
done
[ ! -e "$work/no-machine" ] || fail "a folder was made for a machine that is not there"
# So are recipes, scripts and certificates.
while read -r wrong meant; do
  for verb in check dry-run "up --recipe"; do
    expect_exit 3 "$verb $wrong" "$gantry" $verb "$wrong"
    expect_text "$wrong: $meant"
  done
done <<'END'
recipes/demo-bord.yaml there is no such file; did you mean 'recipes/demo-board.yaml'?
recipes/demo-board there is no such file; did you mean 'recipes/demo-board.yaml'?
recipes/demo-board.yml there is no such file; did you mean 'recipes/demo-board.yaml'?
README.mdd there is no such file; did you mean 'README.md'?
recipe/demo-board.yaml there is no folder 'recipe'; did you mean 'recipes'?
nowhere/at/all.yaml there is no folder 'nowhere'
recipes/zzzzzzzzzzzzzzz.yaml there is no such file in 'recipes'
README.md/x.yaml 'README.md' is no folder
END
expect_exit 3 "a certificate" "$gantry" run $demo --certificate recipes/demo-bord.yaml --state "$work/nobody"
expect_text "did you mean 'recipes/demo-board.yaml'?"
expect_exit 3 "a folder that is not there" "$gantry" --machine "$work/none/m.yaml" check
expect_text "looked for in $work/none"
expect_exit 3 "the same for a job" "$gantry" --machine "$work/none/m.yaml" dry-run $demo --out "$work/job"
expect_text "looked for in $work/none"
(cd "$work" && "$gantry" --machine dispenser check >"$work/out" 2>"$work/err") || fail "a machine that comes with gantry is not found by its name"
expect_text "config/machines/dispenser.yaml: [0-9]* axes"

mkdir -p "$work/alone/machines"
cp config/machines/dispenser.yaml "$work/alone/machines/mine.yaml"
expect_exit 3 "a machine file without its profiles" "$gantry" --machine "$work/alone/machines/mine.yaml" check
expect_text "mine.yaml:[0-9]*:[0-9]*: there are no profiles beside this machine file; looked in $work/alone/drives and $work/alone/devices for: dio16, id286, amd530b, std402ec, iss57; .*gantry init"
[ "$(grep -c '\[G' "$work/err")" = 1 ] || fail "several messages for one mistake"
ln -s loop "$work/loop"
expect_exit 3 "a link that leads to itself" "$gantry" --machine "$work/loop" check
expect_text "loop: cannot be opened (Too many levels of symbolic links)"
cp -r config/drives config/devices "$work/alone/"
sed -i 's/profile: id286/profile: id268/' "$work/alone/machines/mine.yaml"
expect_exit 3 "a misspelt profile" "$gantry" --machine "$work/alone/machines/mine.yaml" check
expect_text "did you mean 'id286'?"

# What is wrong by itself is told before the recipe is read and proved.
while read -r option value; do
  for verb in run "up --recipe"; do
    expect_exit 2 "$verb with $option $value" "$gantry" --machine "$work/none/m.yaml" $verb $demo $option "$value" --state "$work/nobody"
    expect_text "$option: "
  done
done <<'END'
--bus foo
--bus ethercat:
--world here
--loop-cpu -1
--loop-cpu 9999
--domain 999
--interface lo9
--peer here
--peer 300.1.1.1
--name a-name-that-is-longer-than-31-bytes
END

# What is of the simulated machine does not go with a bus: nobody would hear of it.
for option in "--sim-board dx=1mm" "--sim-script recipes/demo-board.yaml" "--sim-state $work/world"; do
  for verb in "run $demo --out $work/no-world" up; do
    expect_exit 2 "$verb on a bus with $option" "$gantry" $verb --bus ethercat:lo $option --state "$work/nobody"
    expect_text "${option%% *}: goes with the simulated machine, and the machine is on 'ethercat:lo'"
  done
done
# So are folders in which no file can be made, and a script that cannot be read; a recipe of many dots takes long to prove.
mkdir "$work/holds-a-job" && echo '{}' >"$work/holds-a-job/summary.json"
not_proved() { grep -q "proved free\|proving" "$work/err" && fail "$1: the recipe was proved before"; }
for verb in dry-run "run --state $work/nobody"; do
  for folder in /proc /proc/none /etc/passwd "$work/loop" "$work/loop/below" "$work/holds-a-job"; do
    expect_exit 2 "$verb --out $folder" "$gantry" $verb $demo --out "$folder"
    not_proved "--out $folder"
  done
  for folder in /proc /proc/none /etc/passwd "$work/loop"; do
    expect_exit 2 "$verb --sim-state $folder" "$gantry" $verb $demo --sim-state "$folder" --out "$work/no-world"
    expect_text "--sim-state: "
    not_proved "--sim-state $folder"
  done
  expect_exit 3 "$verb with a script that is not there" "$gantry" $verb $demo --sim-script "$work/none.yaml" --out "$work/no-world"
  expect_text "none.yaml: there is no such file"
  not_proved "a script that is not there"
  printf -- '- {do: cut_lnk}\n- {do: remove_mrk, name: a}\n' >"$work/slips.yaml"
  expect_exit 3 "$verb with a script with two slips" "$gantry" $verb $demo --sim-script "$work/slips.yaml" --out "$work/no-world"
  expect_text "slips.yaml:1:.*did you mean 'cut_link'"
  expect_text "slips.yaml:2:.*did you mean 'remove_mark'"
  not_proved "a script with slips"
  # What the board lacks is known when the recipe is read: nothing is made for a job that cannot go as it was meant.
  printf -- '- {at: mark nw, do: remove_mark, name: mark_nw}\n- {at: feature dot 900, do: cut_link, station: y1}\n' >"$work/other.yaml"
  expect_exit 3 "$verb with a script for another board" "$gantry" $verb $demo --sim-script "$work/other.yaml" --out "$work/no-world"
  expect_text "other.yaml:1:.*there is no mark 'nw'"
  expect_text "other.yaml:1:.*there is no mark 'mark_nw'"
  expect_text "other.yaml:2:.*there is no dot 900; the board has"
  grep -q homing "$work/err" && fail "it homed"
done
[ ! -e "$work/no-world" ] || fail "a folder was made for a job that never began"
for verb in "up --state $work/nobody" "home --state $work/nobody" "sim --interface lo"; do
  expect_exit 2 "$verb --sim-state /proc" timeout 20 "$gantry" $verb --sim-state /proc
done
for flag in --json --quiet --verbose; do
  expect_exit 2 "$flag=5" "$gantry" $flag=5 check $demo
  expect_text "'$flag' takes no value; write it alone"
done
expect_exit 2 "--force=no" "$gantry" dry-run $demo --out "$work/no-world" --force=no
expect_text "'--force' takes no value; write it alone"

# Before anything moves, also where the simulated machine needs no state.
for state in /etc/passwd /etc/passwd/below; do
  expect_exit 7 "a job whose --state is no folder: $state" "$gantry" run $demo --state $state --out "$work/no-state"
  expect_text "the state folder is a link or no folder"
  grep -q homing "$work/err" && fail "it homed"
  expect_exit 7 "an order whose --state is no folder: $state" "$gantry" status --state $state
done
[ ! -e "$work/no-state" ] || fail "the job began"
for percent in nan inf -inf -5 0.5 201 much; do
  expect_exit 2 "override $percent, without an owner" "$gantry" override --state "$work/nobody" -- $percent
done
for serial in $'S-1\nS-2' $'S\e[31m' $'S\xe2\x80\xae1' "$(printf %0129d 0)"; do
  for verb in "dry-run $demo" "run $demo" part-removed; do
    expect_exit 2 "$verb with a serial that is none" "$gantry" $verb --serial "$serial"
    expect_text "--serial: has"
  done
done
expect_exit 2 "override -5" "$gantry" override -5 --state "$work/nobody"
