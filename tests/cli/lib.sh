# For the tests of the program as a user runs it: bash tests/cli/NAME.sh GANTRY
set -uo pipefail
gantry=$(realpath "$1")
source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$source_dir" || exit 1
work=$(mktemp -d)
failures=0
pids=()
finish() {
  for p in "${pids[@]:-}"; do [ -n "$p" ] && kill "$p" 2>/dev/null; done
  wait 2>/dev/null
  rm -rf "$work"
  [ "$failures" = 0 ] || exit 1
}
trap finish EXIT
fail() { echo "FAILED: $*"; failures=$((failures + 1)); }
# expect_exit CODE WHAT COMMAND...: stdout and stderr go to $work/out and $work/err. A job that is to end well and that the
# host held up for longer than the machine file tolerates (exit 8; G121: half of its cycles, G123: 50 ms) has shown nothing
# and is run again, twice, in place of the first.
expect_exit() {
  local code=$1 what=$2 got attempt again=(); shift 2
  [[ " $* " == *" --out "* ]] && again=(--force)
  for attempt in 1 2 3; do
    [ "$attempt" = 1 ] || set -- "$@" "${again[@]}"
    "$@" >"$work/out" 2>"$work/err" </dev/null
    got=$?
    [ "$code" = 0 ] && [ "$got" = 8 ] && grep -qE "G121|G123" "$work/err" || break
    echo "held up by the host: $what, attempt $attempt"
  done
  [ "$got" = "$code" ] && echo "ok: $what" || { fail "$what: exit $got, expected $code"; tail -5 "$work/err"; }
}
expect_text() { grep -q -- "$1" "$work/out" "$work/err" || { fail "no '$1' in the output"; cat "$work/out" "$work/err" | tail -5; }; }
# The reference machine on a host that may hold up this program, or the one at the other end of its wire: it forgives more lost
# frames, more late cycles, longer silence on the wire and larger deviations in the drives than a machine of steel should. What
# these tests judge is not time.
patient_machine() {
  mkdir -p "$work/config/machines" && cp -r config/drives config/devices "$work/config" &&
    sed -i 's/^watchdog: 100 ms$/watchdog: 3000 ms/' "$work"/config/drives/*.yaml "$work"/config/devices/*.yaml &&
    sed -e 's/^  frames_lost_max: 3$/  frames_lost_max: 50/' -e 's/^\(  stop_after_missed: .*\)sim: 50}$/\1sim: 1000}/' \
      -e 's/position_error_limit: [0-9]* counts/position_error_limit: 30000 counts/' \
      -e 's/position_error_delay: 200 ms/position_error_delay: 2000 ms/' \
      config/machines/dispenser.yaml >"$work/config/machines/patient.yaml"
  echo "$work/config/machines/patient.yaml"
}
# From here on `gantry` is the program with that machine, which homes quickly, as most of a short job is homing. (Over a
# wire that makes the counts at which an axis comes to rest depend on when its drive was heard.)
use_patient_machine() {
  local machine; machine=$(patient_machine)
  sed -i -e 's/fast: 60 mm.s, slow: 5 mm.s, acceleration: 1000 /fast: 180 mm\/s, slow: 15 mm\/s, acceleration: 4000 /' \
    -e 's/fast: 30 mm.s, slow: 3 mm.s, acceleration: 500 /fast: 60 mm\/s, slow: 12 mm\/s, acceleration: 2000 /' \
    -e 's/fast: 90 deg.s, slow: 9 deg.s, acceleration: 720 /fast: 120 deg\/s, slow: 20 deg\/s, acceleration: 3600 /' \
    -e 's/fast: 20 mm.s, slow: 2 mm.s, acceleration: 200 /fast: 30 mm\/s, slow: 5 mm\/s, acceleration: 600 /' \
    "$machine"
  printf '#!/bin/sh\nexec "%s" --machine "%s" "$@"\n' "$gantry" "$machine" >"$work/gantry"
  chmod +x "$work/gantry"
  gantry=$work/gantry
}
# cable NAME: a veth pair between this namespace's NAME-ctl and NAME-sim in one of its own, taken away at the end; where it
# cannot be made, root fails and others skip.
cable() {
  if ! scripts/veth-pair up "$1" >"$work/pair" 2>&1; then
    cat "$work/pair"
    [ "$(id -u)" = 0 ] && exit 1
    echo "only root may make a veth pair: nothing to test"
    exit 77
  fi
  # shellcheck disable=SC2064
  trap "ip netns pids $1 2>/dev/null | xargs -r kill; scripts/veth-pair down $1 >/dev/null 2>&1; finish" EXIT
}
hash_of() { grep -o '"setpoint_hash": "[^"]*"' "$1/summary.json"; }
# wait_for SECONDS COMMAND...: until it succeeds
wait_for() { local n=$(($1 * 20)); shift; for _ in $(seq "$n"); do "$@" >/dev/null 2>&1 && return 0; sleep 0.05; done; return 1; }
# Did the host hold a run up: a cycle skipped, a frame lost, or sent so late that the drives may have taken it a SYNC0
# (half a cycle of 1 ms after it is due) later than they should?
host_held_up() {
  python3 - "$@" <<'PY'
import json, sys
def late(c):
    if c["skipped"] > 0 or c["frames_lost"] > 0:
        return True
    if c["virtual_time"]:  # has no times
        return False
    return sum(c[part]["max"] for part in ("wake_us", "compute_us", "bus_us")) >= 500
sys.exit(0 if any(late(json.load(open(d + "/summary.json"))["cycle"]) for d in sys.argv[1:]) else 1)
PY
}
# same_setpoints A B WHAT: two runs commanded the same. Where the host held one of them up, what both sent is compared.
same_setpoints() {
  [ "$(hash_of "$1")" = "$(hash_of "$2")" ] && { echo "ok: $3: same setpoints"; return; }
  "$gantry" trace diff "$1" "$2" >"$work/diff" 2>&1 && host_held_up "$1" "$2" &&
    { echo "ok: $3: the host was late; $(head -1 "$work/diff")"; return; }
  fail "$3: other setpoints"
  cat "$work/diff"
  grep -h '"cycle": {' "$1/summary.json" "$2/summary.json"
}
