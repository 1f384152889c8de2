#!/usr/bin/env bash
# `gantry doctor`: what is missing is found, with its fix, where it is taken away by the kernel's own means: limits, capabilities,
# network namespaces. As root, who can take things away.
source "$(dirname "$0")/lib.sh"
[ "$(id -u)" = 0 ] || { echo "only root can take rights away: nothing to test"; exit 77; }
chmod 755 "$work"
export GANTRY_STATE=$work/state
install -m 755 "$gantry" "$work/gantry"  # where another user may read it
machine=$work/config/machines/dispenser.yaml
mkdir -p "$work/config" && cp -r config/machines config/drives config/devices "$work/config/"
chmod -R a+rX "$work"
gantry="$work/gantry --machine $machine"

# level NAME: of a finding in the JSON on $work/out; has_fix NAME
level() { python3 -c 'import json, sys
print(next((f["level"] for f in json.load(open(sys.argv[1]))["findings"] if f["name"] == sys.argv[2]), "absent"))' "$work/out" "$1"; }
expect_level() { local got; got=$(level "$1"); [ "$got" = "$2" ] && echo "ok: $1 is $2" || fail "$1 is '$got', expected '$2'"; }
expect_sound() {  # every finding that is not ok has a fix; the exit code is the document's
  python3 - "$work/out" "$1" <<'PY' || fail "the document is not sound"
import json, sys
d = json.load(open(sys.argv[1]))
assert d["exit_code"] == int(sys.argv[2]), d["exit_code"]
assert all(f["fix"] for f in d["findings"] if f["level"] != "ok")
worst = max(["ok", "warning", "error"].index(f["level"]) for f in d["findings"])
assert d["result"] == ["ok", "warning", "failed"][worst], d["result"]
PY
}
# doctor CODE WHAT PREFIX... -- OPTIONS...
doctor() {
  local code=$1 what=$2 prefix=(); shift 2
  while [ "$1" != -- ]; do prefix+=("$1"); shift; done; shift
  # shellcheck disable=SC2086
  expect_exit "$code" "$what" "${prefix[@]}" $gantry --json doctor "$@"
  expect_sound "$code"
}
# as_nobody +RIGHT,...: a user who is not root, with these capabilities alone (as by AmbientCapabilities= of systemd)
as_nobody() {
  local rights=-all${1:+,$1}
  nobody=(prlimit --rtprio=0 --memlock=65536 setpriv --reuid 65534 --regid 65534 --clear-groups
    --inh-caps="$rights" --ambient-caps="$rights" --bounding-set="$rights")
}
export HOME=$work
mkdir "$work/theirs" && chown 65534 "$work/theirs"

as_nobody
doctor 0 "a user without rights, for the simulated machine" "${nobody[@]}" -- --state "$work/theirs/state"
expect_level "real-time priority" warning
expect_level "locked memory" warning
expect_level "raw frames" warning
expect_level "state folder" ok
expect_level "CPUs" "$([ "$(nproc)" -gt 1 ] && echo ok || echo warning)"
expect_text "memlock unlimited"
as_nobody +sys_nice
doctor 8 "the same for a bus, with the right to priority" "${nobody[@]}" -- --interface lo --state "$work/theirs/state"
expect_level "real-time priority" ok
expect_level "locked memory" error
as_nobody +sys_nice,+ipc_lock
doctor 5 "with both, without raw frames" "${nobody[@]}" -- --interface lo --state "$work/theirs/state"
expect_level "real-time priority" ok
expect_level "locked memory" ok
expect_level "raw frames" error
doctor 5 "a folder of somebody else" "${nobody[@]}" -- --interface lo --state "$work/none"
expect_level "state folder" error
[ -e "$work/theirs/state" ] && fail "doctor has made a state folder"

doctor 5 "an interface that is not there" unshare -n -- --interface enp9s9
expect_level "interface enp9s9" error
link() { unshare -n bash -c "$1; exec \"\$@\"" bash "${@:2}"; }
# in a network of its own: link COMMANDS PROGRAM...
in_link() { local code=$1 what=$2 commands=$3; shift 3
  # shellcheck disable=SC2086
  expect_exit "$code" "$what" link "$commands" $gantry --json doctor "$@"; expect_sound "$code"; }
in_link 5 "an interface that is down" "ip link add bus0 type veth peer name sta0" --interface bus0
expect_level "interface bus0" error
expect_text "ip link set dev bus0 up"
expect_level "DDS" warning
in_link 5 "an interface without its peer's end" "ip link add bus0 type veth peer name sta0; ip link set bus0 up" --interface bus0
expect_text "no carrier"
up="ip link set lo up; ip link add bus0 type veth peer name sta0; ip link set bus0 up; ip link set sta0 up; sleep 0.1"
in_link 0 "a cable with both ends" "$up" --interface bus0
expect_level "interface bus0" ok
expect_level "owner of the bus" ok
expect_level "other traffic" absent
expect_level "DDS" ok
in_link 5 "a name that is nearly right" "$up" --interface bus1
expect_text "did you mean 'bus0'?"
in_link 0 "an address on the bus" "$up; ip address add 192.168.7.1/24 dev bus0" --interface bus0
expect_level "other traffic" warning
# Another program has the lock of decision 11: a packet socket in a fan-out group that takes one member.
cat >"$work/lock.py" <<'PY'
import os, socket, struct, sys, time
s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, 0)
s.bind((sys.argv[1], 0x88B5))
s.setsockopt(263, 18, struct.pack("=HHI", socket.if_nametoindex(sys.argv[1]), 0, 1))
open(sys.argv[2], "w").write(str(os.getpid()))
time.sleep(60)
PY
in_link 7 "a bus that another program drives" "$up; python3 $work/lock.py bus0 $work/locked & while ! [ -s $work/locked ]; do sleep 0.05; done" --interface bus0
expect_level "owner of the bus" error
expect_text "process [0-9]* (python3)"
kill "$(cat "$work/locked")"

# Somebody publishes to a network.
python3 -c 'import os, sys
os.execv(sys.executable, ["gantry", "-c", "import time; time.sleep(60)", "publish", "--interface", "eth7"])' & publisher=$!
wait_for 5 grep -aq ^gantry "/proc/$publisher/cmdline"
doctor 0 "a machine that publishes to a network" -- --state "$work/none"
expect_level "DDS" warning
expect_text "eth7"
kill "$publisher"

mkdir -p "$work/open" && chmod 777 "$work/open"
doctor 7 "a state folder that others may write to" -- --state "$work/open"
expect_text "chmod 700 $work/open"
ln -s "$work/open" "$work/link"
doctor 7 "a state folder that is a link" -- --state "$work/link"
mkdir "$work/small"
# shellcheck disable=SC2086
source tests/cli/mounts.sh
expect_exit 1 "a disk that is nearly full" "${with_mounts[@]}" bash -c \
  'mount -t tmpfs -o size=4m none "$1" || exit 99; "${@:2}"; code=$?; umount "$1"; exit $code' bash \
  "$work/small" $gantry --json doctor --state "$work/small/state"
expect_level "disk of the state" error
sed -i 's/^axes:/axs:/' "$machine"
doctor 3 "a machine file with a mistake" -- --state "$work/none"
[ ! -e "$work/none" ] || fail "doctor has made the state folder"
