#!/usr/bin/env bash
# An owner as the service has it: its state is its own, its socket is open to its group and found by clients that were told
# nothing.
source "$(dirname "$0")/lib.sh"
use_patient_machine
unset GANTRY_STATE XDG_STATE_HOME
export HOME=$work/home GANTRY_SOCKET=$work/run/owner.sock
mkdir -p "$work/home" "$work/run" "$work/log"
chmod 755 "$work"  # others come as far as the folder of the socket

expect_exit 7 "no owner anywhere" "$gantry" status
expect_text 'start one with `gantry up`'
(cd "$work/log" && umask 027 && exec "$gantry" up --state "$work/state" --socket "$work/run/owner.sock") >"$work/up.out" 2>&1 </dev/null &
owner=$!; pids+=($owner)
wait_for 40 grep -q "is up; orders on $work/run/owner.sock" "$work/up.out" || { fail "the owner did not come up"; cat "$work/up.out"; }
[ "$(stat -c %a "$work/run/owner.sock")" = 660 ] || fail "the socket has mode $(stat -c %a "$work/run/owner.sock")"
[ "$(stat -c %a "$work/state")" = 700 ] || fail "the state folder has mode $(stat -c %a "$work/state")"

expect_exit 0 "a client that was told nothing" "$gantry" --json status
expect_text '"state": "disabled"'
expect_exit 0 "one that was told its state folder" "$gantry" status --state "$work/state"
expect_exit 7 "one that was told another" "$gantry" status --state "$work/other"
expect_exit 7 "a second owner on the socket" "$gantry" up --state "$work/other" --socket "$work/run/owner.sock"
expect_text "another .gantry up. owns this machine"
sed 's/^machine: .*/machine: another/' "$work/config/machines/patient.yaml" >"$work/config/machines/another.yaml"
printf '#!/bin/sh\nexec "%s" --machine "%s" "$@"\n' "$(realpath "$1")" "$work/config/machines/another.yaml" >"$work/another"
chmod +x "$work/another"
expect_exit 2 "homing of another machine" "$work/another" home
expect_text "the owner that is up has"
expect_exit 0 "a job that was told no folder" "$gantry" run tests/cli/short-board.yaml
expect_text "goes to the owner that is up ($work/run/owner.sock)"
[ -s "$work/log/out/short-board-001/summary.json" ] || fail "its results are not where the owner stands"
case "$(stat -c %a "$work/log/out/short-board-001/report.html")" in 640) ;; *) fail "the group cannot read its report" ;; esac

# Who is not in the group is told how to get in, and may have a machine of their own.
if [ "$(id -u)" = 0 ] && setpriv --reuid=65534 --regid=65534 --clear-groups true 2>/dev/null; then
  mkdir -p "$work/nobody" && chown 65534:65534 "$work/nobody"
  # The program where nobody can reach it, and with it that machine.
  install -m 755 "$(realpath "$1")" "$work/reachable"
  printf '#!/bin/sh\nexec "%s" --machine "%s" "$@"\n' "$work/reachable" "$work/config/machines/patient.yaml" >"$work/gantry"
  as_nobody() { setpriv --reuid=65534 --regid=65534 --clear-groups env HOME="$work/nobody" "$@"; }
  expect_exit 7 "a stranger's order" as_nobody "$gantry" abort
  expect_text "you may not give it orders.*adduser"
  mkdir -m 1777 "$work/open" && touch "$work/open/held"
  setpriv --reuid=65534 --regid=65534 --clear-groups flock "$work/open/owner.sock.lock" sh -c "while [ -e '$work/open/held' ]; do sleep 0.1; done" &
  wait_for 10 test -e "$work/open/owner.sock.lock"
  expect_exit 7 "a lock that a stranger holds" "$gantry" up --state "$work/squatted" --socket "$work/open/owner.sock"
  expect_text "owner.sock.lock. belongs to user 65534"
  rm "$work/open/held"
  expect_exit 0 "one of the group" setpriv --reuid=65534 --regid=65534 --groups 0 env HOME="$work/nobody" "$gantry" status
fi
expect_exit 0 "the end" "$gantry" down
wait $owner
[ ! -e "$work/run/owner.sock" ] && [ ! -L "$work/state/owner.sock" ] || fail "a socket was left"
