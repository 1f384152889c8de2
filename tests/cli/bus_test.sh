#!/usr/bin/env bash
# gantry bus: on the virtual segment in process, on gantry sim over a wire, and on stations that no machine file knows.
source "$(dirname "$0")/lib.sh"
json() { python3 -c "import json,sys; d=json.load(open('$work/out')); print($1)"; }
expect_value() { local got; got=$(json "$1"); [ "$got" = "$2" ] && echo "ok: $1 is $2" || fail "$1 is '$got', expected '$2'"; }

expect_exit 0 "a scan in process" "$gantry" --json bus scan
expect_value "len(d['stations'])" 6
expect_value "d['stations'][5]['configured_name']" cu
expect_value "[s['parent'] for s in d['stations']]" "[-1, 0, 1, 2, 3, 4]"
expect_value "sum(len(p['entries']) for p in d['stations'][5]['pdos'])" 8
expect_exit 0 "objects" "$gantry" --json bus scan --objects
expect_exit 0 "a table" "$gantry" bus scan
expect_text "1 'x' "; expect_text "6040h/16 607Ah/32"
expect_exit 0 "a read by name" "$gantry" --json bus sdo read y1 0x1018:2
expect_value "d['value']" 1
expect_exit 0 "a string" "$gantry" bus sdo read 5 1008h --type string
expect_text "STD402EC"
expect_exit 0 "a signed write" "$gantry" --json bus sdo write x 0x607A -5
expect_value "(d['value'], d['bytes'])" "(-5, 'FBFFFFFF')"
expect_exit 5 "an object that is not there" "$gantry" bus sdo read x 0x5FFF
expect_text "06020000h"
expect_exit 5 "a value out of range" "$gantry" bus sdo write x 0x6098 101
expect_exit 5 "objects of a station without mailbox" "$gantry" bus sdo read io 0x6000:1
expect_text "no mailbox"
expect_exit 2 "a station that is not there" "$gantry" bus sdo read nobody 0x1018
expect_text "positions 0 to 5, io, x, y1"
expect_exit 2 "an object that is none" "$gantry" bus sdo read x here
expect_exit 2 "a value that does not fit" "$gantry" bus sdo write x 0x6098 300
expect_exit 2 "a verb that is none" "$gantry" bus frobnicate
expect_text "no .gantry bus frobnicate.*known: scan, sdo"
expect_exit 2 "no verb" "$gantry" bus
expect_exit 2 "an option that is none" "$gantry" bus scan --foo
expect_exit 5 "a type of another length" "$gantry" bus sdo read x 1018:1 --type u8
expect_text "station 1 'x'.*has 4 bytes, u8 has 1"
expect_exit 5 "an error names the station as a success does" "$gantry" bus sdo read x 0x5FFF
expect_text "station 1 'x'"
expect_exit 0 "a write of an object whose type only the station knows" "$gantry" --json bus sdo write x 0x10F1:2 7
expect_value "(d['type'], d['value'])" "('u32', 7)"
expect_exit 2 "and its range is the type's" "$gantry" bus sdo write x 0x10F1:2 4294967296
expect_exit 0 "a complete read" "$gantry" --json bus sdo read x 0x10F1 --complete
whole=$(json "d['value']")
expect_exit 0 "a complete write" "$gantry" --json bus sdo write x 0x10F1 "${whole%????????}09000000" --complete
expect_value "d['value'] == '${whole%????????}09000000'" True
expect_exit 2 "an unknown type" "$gantry" bus sdo read x 0x6064 --type float
expect_exit 5 "an interface that is not there" "$gantry" bus scan --interface none0
expect_exit 0 "clocks" "$gantry" --json bus dc
expect_value "max(abs(s['difference_ns']) for s in d['stations']) < 1000" True
expect_value "{s['sync0_cycle_ns'] for s in d['stations'][1:]}" "{1000000}"
expect_exit 0 "clocks for a while" "$gantry" --json bus dc --watch 0.1
expect_value "all(abs(s['difference_ns']) <= s['largest_difference_ns'] < 1000 for s in d['stations'])" True
expect_exit 0 "error counters" "$gantry" --json bus errors
expect_exit 0 "a capture of a bring-up" "$gantry" bus capture "$work/up.pcapng"
judge() { # FILE: what tshark says of it
  frames=$(tshark -r "$1" -Y ecat 2>/dev/null | wc -l); bad=$(tshark -r "$1" -Y '_ws.malformed' 2>/dev/null | wc -l)
  [ "$frames" -gt 100 ] && [ "$bad" = 0 ] && echo "ok: $frames frames, none malformed" || fail "$1: $frames frames, $bad malformed"
}
judge "$work/up.pcapng"
expect_exit 1 "a capture where nothing can be written" "$gantry" bus capture /proc/nothing.pcapng

name=gbus$$
if ! scripts/veth-pair up $name >"$work/pair" 2>&1; then
  [ "$(id -u)" = 0 ] && { cat "$work/pair"; fail "no veth pair"; exit 1; }
  echo "only root may make a veth pair: the rest is not tested"
  exit 0
fi
trap 'ip netns pids $name 2>/dev/null | xargs -r kill; scripts/veth-pair down $name >/dev/null 2>&1; finish' EXIT
inside() { scripts/veth-pair exec $name -- "$@"; }
scripts/veth-pair exec $name -- "$gantry" sim --interface $name-sim >"$work/sim.out" 2>&1 </dev/null &
sim=$!; pids+=($sim)
wait_for 10 inside "$gantry" bus scan --interface $name-ctl || fail "no scan over the wire"
scripts/veth-pair exec $name -- "$gantry" bus capture "$work/wire.pcapng" --interface $name-ctl >"$work/capture.out" 2>&1 </dev/null &
capture=$!; pids+=($capture)
wait_for 5 test -s "$work/wire.pcapng"; sleep 0.3
expect_exit 0 "a scan over a wire" inside "$gantry" --json bus scan --objects --interface $name-ctl
expect_value "[s['configured_name'] for s in d['stations']]" "['io', 'x', 'y1', 'y2', 'z', 'cu']"
expect_value "d['stations'][1]['state']" "PRE_OP"
expect_exit 0 "a write over a wire" inside "$gantry" bus sdo write z 0x6081 4711 --interface $name-ctl
expect_exit 0 "is still there for the next" inside "$gantry" --json bus sdo read 4 6081 --interface $name-ctl
expect_value "d['value']" 4711
expect_exit 0 "and for the one after that" inside "$gantry" --json bus sdo read 4 6081 --interface $name-ctl
kept=$work/state/accepted-ethercat.json
expect_kept() { cp "$kept" "$work/out"; expect_value "$1" "$2"; }
mkdir "$work/foreign" && cp -r config/drives config/devices config/machines "$work/foreign"
expect_exit 0 "a value that acts at once" inside "$gantry" bus sdo write z 0x6081 4712 --interface $name-ctl --state $work/state
[ ! -e "$kept" ] || fail "nothing waits for a supply, and $kept is there"
expect_exit 0 "one that acts at power-up" inside "$gantry" bus sdo write cu 22F2 4000 --interface $name-ctl --state $work/state
expect_text "until this station's supply was off and on"
expect_exit 0 "and what it was before" inside "$gantry" bus sdo write cu 22F2 10000 --interface $name-ctl --state $work/state
inside "$gantry" --json commission cu --interface $name-ctl --state $work/state >$work/out
expect_value "[s['restart_pending'] for s in d['stations']]" "[True]"
expect_kept "list(d['stations'].items())" "[('cu', {'restart_pending': True})]"
sed '/^identity:/s/vendor: 0x[0-9A-F]*/vendor: 0x5A5A/' -i "$work/foreign/drives/id286.yaml"
expect_exit 0 "one of a station that is another than the file has it" inside "$gantry" --machine "$work/foreign/machines/dispenser.yaml" \
  bus sdo write 4 20F2 10000 --type u32 --interface $name-ctl --state $work/state
expect_text "until this station's supply was off and on"
expect_kept "sorted(d['stations'])" "['cu', 'z']"
expect_exit 5 "one that it refuses" inside "$gantry" bus sdo write y2 2000 9000 --interface $name-ctl --state $work/state
expect_kept "sorted(d['stations'])" "['cu', 'z']"
echo "{" >"$kept"
for some in "cu" "cu --accept" "--all" "--all --write"; do
  expect_exit 3 "a folder that cannot be read, and commission $some" inside "$gantry" commission $some --interface $name-ctl --state $work/state
  expect_text "gantry commission --all --accept"
done
expect_exit 5 "accepted anew, and three wait for their supply" inside "$gantry" --json commission --all --accept --interface $name-ctl --state $work/state
expect_value "{s['station']: s['restart_pending'] for s in d['stations']}" \
  "{'io': False, 'x': False, 'y1': False, 'y2': True, 'z': True, 'cu': True}"  # nobody has set up x and y1 since their supply came
expect_kept "{s['compared'] for s in d['stations'].values()}" "{True}"
expect_exit 0 "counters over a wire" inside "$gantry" bus errors --interface $name-ctl
expect_exit 0 "clocks over a wire" inside "$gantry" bus dc --interface $name-ctl
kill -INT $capture; wait $capture || fail "the capture did not end in order"
judge "$work/wire.pcapng"
kill $sim; wait $sim 2>/dev/null

scripts/veth-pair exec $name -- env PYTHONDONTWRITEBYTECODE=1 python3 tests/interop/strange_stations.py $name-sim simple big_box nervous >"$work/strange.out" 2>&1 </dev/null &
strange=$!; pids+=($strange)
wait_for 5 grep -q strange "$work/strange.out"
expect_exit 0 "a scan of strangers" inside "$gantry" --json bus scan --objects --interface $name-ctl
expect_value "[(s['vendor'], s['product'], s['name'], s['configured_name']) for s in d['stations']]" \
  "[(23130, 262, 'stranger', None), (23130, 257, 'stranger', None), (23130, 261, 'stranger', None)]"
expect_value "[len(s['pdos']) for s in d['stations']]" "[2, 2, 2]"
expect_exit 0 "a stranger's object" inside "$gantry" --json bus sdo read 1 1008 --type string --interface $name-ctl
expect_value "d['value']" "a name that does not fit into four bytes"
expect_exit 0 "and read by the next tool" inside "$gantry" bus sdo read 1 1018:1 --interface $name-ctl
expect_exit 0 "and by the one after that" inside "$gantry" bus sdo read 1 1018:1 --interface $name-ctl
expect_exit 5 "a name of the machine file whose station is not there" inside "$gantry" bus sdo read x 0x6064 --interface $name-ctl
kill $strange; wait $strange 2>/dev/null

scripts/veth-pair exec $name -- env PYTHONDONTWRITEBYTECODE=1 python3 tests/interop/strange_stations.py $name-sim \
  simple booting stubborn deaf nameless big_box >"$work/strange.out" 2>&1 </dev/null &
strange=$!; pids+=($strange)
wait_for 5 grep -q strange "$work/strange.out"
expect_exit 0 "a scan of stations of which four refuse" inside "$gantry" --json bus scan --objects --interface $name-ctl
expect_value "[s['product'] for s in d['stations']]" "[262, 263, 264, 265, 0, 257]"
expect_value "[len(s['pdos']) for s in d['stations']]" "[2, 0, 0, 0, 0, 2]"
expect_value "['BOOT' in d['stations'][1]['pdos_missing'], '0014h' in d['stations'][2]['pdos_missing'], 'no reply' in d['stations'][3]['pdos_missing']]" "[True, True, True]"
expect_value "d['stations'][4]['eeprom_damage'].count('2000h')" 1
expect_exit 0 "and as a table" inside "$gantry" bus scan --interface $name-ctl
expect_text "no PDO map: the station is in BOOT"; expect_text "^5 stranger"
kill $strange; wait $strange 2>/dev/null
expect_exit 5 "a bus where nobody answers" inside "$gantry" bus scan --interface $name-ctl
