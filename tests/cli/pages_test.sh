#!/usr/bin/env bash
# Manual page and completion are written from the verbs: what the help names stands in them, and they work.
source "$(dirname "$0")/lib.sh"
verbs() { "$gantry" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z-]*\) .*/\1/p'; }
[ "$(verbs | wc -l)" -gt 20 ] || fail "the verbs cannot be read from the help"

"$gantry" pages man >"$work/gantry.1" || fail "no manual page"
for verb in $(verbs); do
  grep -qx "\.SS gantry ${verb//-/\\\\-}" "$work/gantry.1" || fail "$verb is not in the manual page"
  for option in $("$gantry" "$verb" --help | grep -oE '^  (-[a-z],)?--[a-z-]+' | grep -o -- '--.*'); do
    grep -qF -- "${option//-/\\-}" "$work/gantry.1" || fail "$verb $option is not in the manual page"
  done
done
if command -v groff >/dev/null; then
  groff -man -Tutf8 -ww "$work/gantry.1" 2>"$work/err" >"$work/out"
  [ -s "$work/err" ] && fail "groff warns: $(head -3 "$work/err")"
  sed 's/\x1b\[[0-9;]*m//g; s/.\x08//g' "$work/out" >"$work/text"
  grep -q -- '--sim-board' "$work/text" || fail "the rendered page has no --sim-board"
fi

"$gantry" pages bash-completion >"$work/completion" || fail "no completion"
bash -n "$work/completion" || fail "the completion is no bash"
# complete WORDS...: what is offered for the last of them
complete_words() { bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _gantry; printf "%s\n" "${COMPREPLY[@]}"' bash "$work/completion" "$@"; }
[ "$(complete_words gantry dry)" = dry-run ] || fail "dry is not completed"
[ "$(complete_words gantry --json dry-run x.yaml --sim-bo)" = --sim-board ] || fail "--sim-bo is not completed"
[ "$(complete_words gantry bus sc)" = scan ] || fail "bus sc is not completed"
[ -z "$(complete_words gantry check --sim-bo)" ] || fail "check has no --sim-board"
[ "$(complete_words gantry "" | grep -vc '^--')" = "$(verbs | wc -l)" ] || fail "not all verbs are offered"
