#!/usr/bin/env bash
# Output that nobody takes, and a working folder that is gone: a message that says so, and no job that is lost for it.
source "$(dirname "$0")/lib.sh"
demo=$PWD/recipes/demo-board.yaml

# /dev/full refuses every byte, as a full disk does behind a redirection.
into_full() {
  local code=$1 what=$2 got; shift 2
  "$@" >/dev/full 2>"$work/err" </dev/null
  got=$?
  : >"$work/out"
  [ "$got" = "$code" ] && echo "ok: $what" || fail "$what: exit $got, expected $code"
}
while read -r words; do
  into_full 1 "gantry $words" "$gantry" $words
  expect_text "stdout: what was to be printed has not arrived (.*) \[G902\]"
  expect_text "remedy: check free space"
done <<END
explain G207
--json explain G207
--help
--version
pages man
--json check $demo
-q dry-run $demo --out $work/full
END
grep -q '"result": "done"' "$work/full/summary.json" || fail "the job was not done"
into_full 3 "its own mistake comes first" "$gantry" --json check "$work/none.yaml"
expect_text "none.yaml: there is no such file"
into_full 7 "and what it refuses" "$gantry" --json status --state "$work/nobody"
"$gantry" explain 2>"$work/err" | head -1 >"$work/out"
[ "${PIPESTATUS[0]}" = 0 ] && [ ! -s "$work/err" ] || fail "a reader that has seen enough is no mistake"

# The folder one stands in is gone.
mkdir "$work/gone" && cd "$work/gone" && rmdir "$work/gone"
while read -r code words; do
  expect_exit "$code" "gantry $words, in no folder" "$gantry" $words
  expect_text "the folder that this program stands in was deleted: go to one that exists (cd), or give names from / on"
done <<END
2 dry-run $demo
2 dry-run recipe.yaml
2 run $demo --state $work/state
2 run recipe.yaml --out $work/out-1 --state $work/state
2 up --state state
2 init machine
3 check recipe.yaml
END
expect_exit 0 "names from / on" "$gantry" -q dry-run "$demo" --out "$work/absolute"
expect_exit 7 "an order asks for no folder" "$gantry" abort --state "$work/nobody"

# It goes while the job runs, and the results with it: the job goes on, and the terminal says what it came to.
mkdir "$work/stand" && cd "$work/stand"
(until [ -e "$work/stand/out/demo-board-001" ]; do :; done; rm -rf "$work/stand") &
expect_exit 1 "a job whose folder goes" "$gantry" dry-run "$demo"
wait $!
expect_text "35 of 35 features"
expect_text "board          whole"
expect_text "out/demo-board-001: summary.json is not kept (.*); the job itself ended as 'done', with the board whole \[G902\]"
! grep -q "internal error" "$work/err" || fail "internal error"
