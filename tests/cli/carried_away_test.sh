#!/usr/bin/env bash
# The program as it is carried away: installed into a folder, run from another, with nothing of the tree that it was built
# from. And `gantry init`, which copies a machine and a recipe.
source "$(dirname "$0")/lib.sh"
built=$gantry
build_dir=$(dirname "$(dirname "$gantry")")

cmake --install "$build_dir" --prefix "$work/usr" >"$work/out" 2>"$work/err" && echo "ok: installed" || fail "$(cat "$work/err")"
for file in bin/gantry share/gantry/config/machines/dispenser.yaml share/gantry/config/schema/machine.schema.json \
  share/gantry/recipes/demo-board.yaml share/gantry/recipes/paths/wave.csv share/gantry/recipes/schema/recipe.schema.json \
  share/doc/gantry/LICENSE share/doc/gantry/docs/operating.md; do
  [ -s "$work/usr/$file" ] || fail "$file is not installed"
done
for folder in config/machines config/drives config/devices; do
  [ "$(cd "$folder" && ls -- *.yaml)" = "$(cd "$work/usr/share/gantry/$folder" && ls)" ] || fail "$folder is not installed as it is"
done
find "$work/usr" -name '*.cpp' -o -name '*.hpp' | grep -q . && fail "sources are installed"
gantry=$work/usr/bin/gantry

mkdir "$work/elsewhere" && cd "$work/elsewhere" || exit 1
expect_exit 0 "version" "$gantry" --version
[ "$(cat "$work/out")" = "$("$built" --version)" ] || fail "another version"
grep -qE '^gantry [0-9]+\.[0-9]+\.[0-9]+ \([0-9a-f]{12}(-dirty)?\)$' "$work/out" || fail "the version names no commit: $(cat "$work/out")"
expect_exit 0 "a recipe that is installed, checked" "$gantry" check "$work/usr/share/gantry/recipes/demo-board.yaml"
expect_text "$work/usr/share/gantry/config/machines/dispenser.yaml"
expect_exit 0 "the same in a dry run" "$gantry" --json dry-run "$work/usr/share/gantry/recipes/demo-board.yaml" --out "$work/job"
grep -rl --include='*.json' "$source_dir" "$work/job" && fail "the result names files of the source tree"
expect_exit 2 "a drive that nobody knows" "$gantry" explain nodrive:1
expect_text "no drive 'nodrive' in $work/usr/share/gantry/config/drives"
expect_exit 3 "a machine that is not there" "$gantry" --machine nothing.yaml check
expect_text "looked for in $work/elsewhere and $work/usr/share/gantry/config/machines"
# Moved as a whole, and called by a link.
mv "$work/usr" "$work/opt" && ln -s "$work/opt/bin/gantry" "$work/elsewhere/g"
gantry=$work/elsewhere/g
expect_exit 0 "moved, called by a link" "$gantry" explain std402ec:8611
expect_exit 0 "its machine, by its name" "$gantry" --machine dispenser check
expect_text "$work/opt/share/gantry/config/machines/dispenser.yaml"

expect_exit 0 "init" "$gantry" init "$work/mine"
grep '^  gantry ' "$work/out" >"$work/next"
[ "$(wc -l <"$work/next")" = 3 ] || fail "init names $(wc -l <"$work/next") commands"
cmp -s "$work/mine/config/machines/dispenser.yaml" "$source_dir/config/machines/dispenser.yaml" || fail "another machine file"
# What it says comes next works, in virtual time, and with the files that it has copied.
cd "$work/mine" || exit 1
for verb in check dry-run; do
  # shellcheck disable=SC2046
  expect_exit 0 "init's next: $verb" "$gantry" $(sed -n "s/^  gantry \(.* $verb .*\)/\1/p" "$work/next")
done
sed -i 's/^machine: dispenser$/machine: mine/' config/machines/dispenser.yaml
# shellcheck disable=SC2046
expect_exit 0 "its own name" "$gantry" $(sed -n "s/^  gantry \(.* check .*\)/\1/p" "$work/next")
expect_text "features on 'mine'"
sed -i 's/title: iD286-ECFA/title: iD286-MINE/' config/drives/id286.yaml
expect_exit 0 "its own profile is used" "$gantry" --machine config/machines/dispenser.yaml explain id286
expect_text "iD286-MINE"
cd "$work/elsewhere" || exit 1
find "$work/mine" -type f -exec sha256sum {} + | sort >"$work/before"
expect_exit 7 "init over a machine" "$gantry" init "$work/mine"
expect_text "is not overwritten"
find "$work/mine" -type f -exec sha256sum {} + | sort | cmp -s - "$work/before" || fail "init has changed files that were there"
mkdir -p "$work/half/recipes" && echo mine >"$work/half/recipes/demo-board.yaml"
expect_exit 7 "init where one of the files is" "$gantry" init "$work/half"
[ "$(find "$work/half" -type f | wc -l)" = 1 ] || fail "init has written half of it"
# Whatever stands in its way: it leaves what was there, and nothing else.
in_the_way() { # EXIT TEXT NAME: in $work/way, which is $work/before after it
  (cd "$work/way" && find . | sort) >"$work/before"
  expect_exit "$1" "init where $3" "$gantry" init "$work/way"
  expect_text "$2"
  (cd "$work/way" && find . | sort) | cmp -s - "$work/before" || fail "init where $3 has left something: $(find "$work/way")"
  rm -rf "$work/way"
}
for each in recipes config config/drives recipes/schema config/machines; do
  mkdir -p "$(dirname "$work/way/$each")" && echo mine >"$work/way/$each"
  in_the_way 7 "way/$each: is there already and is no folder; name another folder" "'$each' is a file"
done
mkdir "$work/way" && ln -s nowhere "$work/way/recipes"
in_the_way 7 "way/recipes: is there already and is no folder" "'recipes' is a link that leads nowhere"
touch "$work/file"
expect_exit 7 "init on a file" "$gantry" init "$work/file"
expect_exit 7 "init below a file" "$gantry" init "$work/file/mine"
expect_text "/file: is there already and is no folder; name another folder"
# A disk that is full before all of it is written.
mkdir "$work/way"
if mount -t tmpfs -o size=64k none "$work/way" 2>/dev/null; then
  expect_exit 2 "init where there is no room" "$gantry" init "$work/way/new/mine"
  expect_text "No space left on device"
  [ -z "$(ls "$work/way")" ] || fail "init has left half of it: $(find "$work/way")"
  umount "$work/way"
fi
rmdir "$work/way"
expect_exit 2 "init where nothing can be written" "$gantry" init /proc/none
expect_exit 0 "init as JSON" "$gantry" --json init "$work/json"
python3 -c 'import json, sys; d = json.load(sys.stdin); assert d["result"] == "ok" and len(d["next"]) == 4' <"$work/out" || fail "no JSON"
# Where the files have gone it says where it looked.
rm -r "$work/opt/share"
expect_exit 3 "without its files" "$gantry" init "$work/none"
expect_text "looked for in $work/opt/share/gantry and /usr/local/share/gantry"
