#!/usr/bin/env bash
# Publisher and monitor on a network of three namespaces: machine A - router - machine B, no multicast forwarded. Who
# listens where is judged by ss, by a stranger's packets and by /proc, not by the program. bash dds_network_test.sh GANTRY
source "$(dirname "$0")/../../cli/lib.sh"
a=gdnA$$ b=gdnB$$ r=gdnR$$
if ! unshare --net true 2>"$work/unshare"; then
  cat "$work/unshare"
  [ "$(id -u)" = 0 ] && exit 1
  echo "only root may make network namespaces: nothing to test"
  exit 77
fi
[ "$(id -u)" = 0 ] || { echo "only root may make network namespaces that have names: nothing to test"; exit 77; }
command -v ss >/dev/null || { echo "FAILED: no ss; scripts/setup installs it"; exit 1; }

take_down() {
  for n in $a $b $r; do ip netns pids $n 2>/dev/null | xargs -r kill 2>/dev/null; done
  wait 2>/dev/null
  for n in $a $b $r; do ip netns del $n 2>/dev/null; done
  finish
}
trap take_down EXIT
# Not `ip netns exec`, which also mounts a /sys of its own and so fails inside a chroot.
inside() { local name=$1; shift; nsenter --net="/run/netns/$name" "$@"; }
for n in $a $b $r; do ip netns add $n && inside $n ip link set lo up || exit 1; done
cable() { # NAMESPACE INTERFACE ADDRESS ROUTER_INTERFACE ROUTER_ADDRESS
  inside $r ip link add "$4" type veth peer name "$2" netns "$1" && inside $r ip addr add "$5/24" dev "$4" &&
    inside $r ip link set "$4" up && inside "$1" ip addr add "$3/24" dev "$2" && inside "$1" ip link set "$2" up &&
    inside "$1" ip route add default via "$5" || exit 1
}
cable $a wireA 10.77.1.2 toA 10.77.1.1
cable $b wireB 10.77.2.2 toB 10.77.2.1
inside $r sh -c 'echo 1 >/proc/sys/net/ipv4/ip_forward'

now_ms() { date +%s%3N; }
# on HOST NAMESPACE COMMAND...: there, on a computer that is called so; in the background, where $! is then the command
on() { exec nsenter --net="/run/netns/$2" unshare --uts sh -c 'hostname "$0"; exec "$@"' "$1" "${@:3}"; }
owner=''
# up HOST NAMESPACE OPTIONS...: its process number in $owner, its log in $work/HOST.log
up() {
  local host=$1 name=$2 log=$work/$1.log; shift 2
  on "$host" "$name" "$gantry" up --state "$work/$host" "$@" >"$log" 2>&1 </dev/null &
  owner=$!; pids+=($owner)
  wait_for 60 grep -q "is up" "$log" || { fail "no owner on $host"; cat "$log"; }
}
down() { kill "$1" && wait "$1"; }
publisher_of() { pgrep -P "$1" -f publish; }
sockets_of() { inside "$1" ss -uanpH | grep "pid=$2,"; }
# expect_bound NAMESPACE PID DEVICE WHAT: every UDP socket of the process shows %DEVICE, and there are some
expect_bound() {
  sockets_of "$1" "$2" >"$work/ss"
  local all bound
  all=$(wc -l <"$work/ss") bound=$(awk '{print $4}' "$work/ss" | grep -c "%$3:")
  [ "$all" -ge 2 ] && [ "$all" = "$bound" ] && echo "ok: $4: $all sockets, all on %$3" || { fail "$4: $bound of $all sockets on %$3"; }
  awk '{print "    " $4}' "$work/ss"
}
# stranger FROM ADDRESS PORT...: "open" for each port that does not refuse a packet
stranger() { inside "$1" python3 - "${@:2}" <<'E'
import socket, sys, time
for port in map(int, sys.argv[2:]):
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    s.connect((sys.argv[1], port)); s.settimeout(1)
    s.send(b"RTPS\x02\x01\x01\x10" + bytes(12))
    try: s.recv(1); print("open", port)
    except ConnectionRefusedError: pass
    except TimeoutError: print("open", port)
E
}

echo "--- this computer alone"
export CYCLONEDDS_URI='<CycloneDDS><Domain Id="any"><General><Interfaces><NetworkInterface name="wireA"/></Interfaces></General></Domain></CycloneDDS>'
up left $a
publisher=$(publisher_of $owner)
expect_bound $a "$publisher" lo "publisher, with a CYCLONEDDS_URI that wants another interface"
grep -q "CYCLONEDDS_URI is set and not followed" "$work/left.log" && echo "ok: and says so" || { fail "nothing is said of CYCLONEDDS_URI"; cat "$work/left.log"; }
unset CYCLONEDDS_URI
# The port of its socket for all addresses is where an open socket would be reached from the network.
ports=$(sockets_of $a "$publisher" | awk '{print $4}' | sed 's/.*://')
[ -z "$(stranger $b 10.77.1.2 $ports)" ] && echo "ok: packets from elsewhere are refused on ports" $ports || fail "a port is open to the network: $(stranger $b 10.77.1.2 $ports)"
on left $a "$gantry" --json monitor --for 30 >"$work/lines" 2>"$work/err" </dev/null &
listener=$!; pids+=($listener)
wait_for 30 test -s "$work/lines" || { fail "a monitor on the same computer hears nothing"; cat "$work/err"; }
expect_bound $a $listener lo "monitor"
kill $listener

echo "--- rights"
status() { sed -n "s/^$2:\t//p" "/proc/$1/task/$3/status"; }
tasks=$(ls /proc/$publisher/task) own_nice=$(nice)
for t in $tasks; do
  for want in CapInh=0000000000000000 CapPrm=0000000000000000 CapEff=0000000000000000 CapBnd=0000000000000000 CapAmb=0000000000000000 \
    NoNewPrivs=1 "Uid=65534 65534 65534 65534" "Gid=65534 65534 65534 65534" Groups=; do
    got=$(status $publisher "${want%%=*}" $t | tr '\t' ' ' | sed 's/ *$//')
    [ "$got" = "${want#*=}" ] || fail "thread $t of the publisher: ${want%%=*} is '$got', not '${want#*=}'"
  done
  policy=$(chrt -p $t | sed -n 's/.*policy: //p')
  [ "$policy" = SCHED_OTHER ] || fail "thread $t of the publisher runs as $policy"
  [ "$(awk '{print $19}' /proc/$publisher/task/$t/stat)" = "$own_nice" ] || fail "thread $t of the publisher is not at nice $own_nice"
done
grep -E '^(Uid|Groups|Cap|NoNewPrivs)' /proc/$publisher/status | sed 's/^/    /'
echo "ok: $(echo "$tasks" | wc -w) threads without rights, at normal priority"
files=$(ls -l /proc/$publisher/fd | sed -n 's/.* -> //p' | grep -vE '^(/dev/null|socket:|pipe:|anon_inode:)' | grep -vF "$work/left.log")
[ -z "$files" ] && echo "ok: of the owner's files it has stderr alone" || fail "the publisher has $files"
loop_cpu=$(for t in /proc/$owner/task/*; do chrt -p "$(basename "$t")" | grep -q FIFO && taskset -cp "$(basename "$t")" | sed 's/.*: //'; done | grep -E '^[0-9]+$' | sort | uniq -c | sort -rn | awk 'NR==1{print $2}')
if [ "$(nproc)" -gt 1 ] && [ -n "$loop_cpu" ]; then
  for t in $tasks; do taskset -cp "$t" | sed 's/.*: //' | tr ',' '\n' | awk -F- -v c="$loop_cpu" '{lo=$1; hi=$NF} c>=lo && c<=hi {bad=1} END{exit bad}' ||
    fail "thread $t of the publisher may run on the loop's CPU $loop_cpu"; done
  echo "ok: none may run on the loop's CPU $loop_cpu"
fi
kill -9 "$publisher"
wait_for 30 sh -c "pgrep -P $owner -f publish | grep -qv '^$publisher\$'" && kill -0 $owner && echo "ok: killed, it is started again" || fail "it is not started again"
down $owner; code=$?
[ $code = 0 ] || fail "the owner ended with $code"

echo "--- behind a router"
expect_exit 2 "peers without an interface" inside $a "$gantry" monitor --peer 10.77.2.2
expect_exit 2 "no such interface" inside $a "$gantry" up --state "$work/none" --interface wireX
up left $a --interface wireA --domain 7 --name cell
left=$owner
expect_bound $a "$(publisher_of $left)" wireA "publisher"
expect_exit 5 "without a peer nothing comes through the router" inside $b "$gantry" monitor --interface wireB --domain 7 --for 2
# hears_within_3_s WHAT NAMESPACE OPTIONS...: from the start of the monitor; a host that is busy may need a second attempt
hears_within_3_s() {
  local what=$1 name=$2 best=99999 begin took; shift 2
  for _ in 1 2 3; do
    begin=$(now_ms)
    expect_exit 0 "$what" inside "$name" "$gantry" --json monitor --count 1 --for 10 "$@"
    took=$(($(now_ms) - begin)); [ $took -lt $best ] && best=$took
    [ $best -le 3000 ] && break
  done
  expect_text '"machine":"cell"'
  [ $best -le 3000 ] && echo "ok: $what: state within $best ms" || fail "$what: state after $best ms"
}
hears_within_3_s "the monitor names the machine's address" $b --interface wireB --peer 10.77.1.2 --domain 7 --name cell
up right $b --interface wireB --peer 10.77.1.2 --domain 6 --name cell
hears_within_3_s "the machine names the monitor's address" $a --interface wireA --domain 6
down $owner

echo "--- two machines of one name"
on right $b "$gantry" monitor --interface wireB --peer 10.77.1.2 --domain 7 >"$work/monitor.out" 2>"$work/monitor.log" </dev/null &
listener=$!; pids+=($listener)
wait_for 30 grep -q cell "$work/monitor.out" || fail "the monitor hears nothing"
expect_bound $b $listener wireB "monitor"
up right $b --interface wireB --peer 10.77.1.2 --domain 7 --name cell
begin=$(now_ms)  # it is up: its publisher has run for less than this
for log in left right monitor; do
  wait_for 30 grep -q "two machines are called 'cell'" "$work/$log.log" || { fail "not told in the log of $log"; cat "$work/$log.log"; }
done
took=$(($(now_ms) - begin))
[ $took -le 2000 ] && echo "ok: told by all three within $took ms" || fail "told after $took ms"
for log in left right monitor; do
  line=$(grep "two machines" "$work/$log.log" | tail -1); echo "    $line"
  [[ $line == *"on host left"* && $line == *"on host right"* ]] || fail "$log does not name both hosts"
  [ "$(grep -o 'session [0-9a-f]\{16\}' <<<"$line" | sort -u | wc -l)" = 2 ] || fail "$log does not name both sessions"
  [ "$(grep -c 'two machines' "$work/$log.log")" = 1 ] || fail "$log tells it $(grep -c 'two machines' "$work/$log.log") times"
done
