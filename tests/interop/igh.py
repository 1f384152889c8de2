"""Brings the segment up as the IgH EtherCAT master does: each station by itself through its own state machine, 4-byte
EEPROM reads in one 10-byte look, alias written and read back, watchdog and DC registers in one piece, default mapping."""
import struct

import clocks
import judge
from cyclic import Cyclic
from sii import checksum
from station import INIT, PRE_OP, SAFE_OP, assign_addresses, find_parents
from wire import BRD, BWR, FPWR

CYCLE_NS = 1_000_000

SOURCE = bytes.fromhex("020000001966")  # Ethernet address of its frames


def scan(bus):
    count = bus.ask(BRD, 0, 0x0130, 2).wkc
    bus.ask(BWR, 0, 0x0010, b"\0\0")
    bus.ask(BWR, 0, 0x0900, b"\0")                            # measure the delays
    stations = assign_addresses(bus, count, 0x0001, "igh")    # ring positions from 1
    for s in stations:
        s.read(0x0130, 2)
        base = s.read(0x0000, 12)
        s.fmmus, s.sync_managers = base.data[4], base.data[5]
        judge.demand(s.fmmus >= 3 and s.sync_managers >= 4, f"{s.fmmus} FMMUs, {s.sync_managers} SyncManagers")
        s.read(0x0900, 16)
        s.read(0x0110, 2)
        s.write(0x0500, b"\0")
        s.identify()
        words = [s.eeprom.u16(w) for w in range(8)]
        judge.demand(words[7] & 0xFF == checksum(words[:7]), f"station {s.position}: EEPROM checksum")
        judge.demand(s.read(0x0012, 2).u() == s.alias, f"station {s.position}: alias register")
    find_parents(stations)
    judge.demand([s.parent for s in stations] == list(range(-1, count - 1)), "the stations do not stand in a line")
    return stations


def write_word(s, word, value):
    s.write(0x0502, struct.pack("<BBHHH", 0x81, 0x02, word, 0, value))
    s.eeprom._wait()
    s.eeprom.cache.clear()


def alias_round_trip(s):
    """`ethercat alias`: word 4 and the checksum, then as they were."""
    before = [s.eeprom.u16(w) for w in range(8)]
    for alias in (before[4] ^ 0x1234, before[4]):
        words = before[:4] + [alias] + before[5:7]
        write_word(s, 4, alias)
        write_word(s, 7, checksum(words))
        judge.demand((s.eeprom.u16(4), s.eeprom.u16(7) & 0xFF) == (alias, checksum(words)), "alias not kept")


def configure(s):
    """INIT with what stands in the way acknowledged, everything cleared, mailbox, PRE_OP."""
    s.ask_state(INIT)
    status, _ = s.al_status()
    if status & 0x10:
        s.acknowledge()
    s.wait_state(INIT)
    s.write(0x0600, bytes(16 * s.fmmus))
    s.write(0x0800, bytes(8 * s.sync_managers))
    if s.has_dc:
        s.write(0x0980, b"\0\0")
    s.set_up_mailbox()
    s.write(0x0500, b"\1")
    s.to(PRE_OP)


def sync_manager_types(s):
    """1C00h: what each SyncManager is for (ETG.1000.6 table 67)."""
    if s.mailbox is None:
        return
    types = [s.mailbox.number(0x1C00, k) for k in range(1, s.mailbox.number(0x1C00, 0) + 1)]
    judge.demand(types[:4] == [1, 2, 3, 4], f"station {s.position}: 1C00h says {types}")


def process_data(s, run):
    s.write(0x0400, struct.pack("<H", 0x09C2))
    s.write(0x0420, struct.pack("<H", 5000))                  # 500 ms: a stall of the test's host is not its subject
    judge.demand(s.read(0x0420, 2).u() == 5000, "watchdog time not kept")
    s.set_up_process_sms()
    s.set_up_fmmus(*run.addresses(s))


def main(bus, expected):
    bus.ask(BWR, 0, 0x0120, bytes([INIT | 0x10, 0]))
    stations = scan(bus)
    judge.identities(stations, expected)
    for s in stations:
        alias_round_trip(s)
    for s in stations:
        configure(s)
        sync_manager_types(s)
    judge.pdo_maps(stations, expected)
    judge.object_lists(stations, expected)
    for s in stations:
        if s.mailbox:
            for k in s.axes():
                s.mailbox.put(0x6060 + 0x800 * k, 0, 8, 1)
    run = Cyclic(bus, stations, read_write="LRW")
    for s in stations:
        process_data(s, run)
    run.reference, _ = clocks.latch_and_offset(bus, stations)
    clocks.static_drift(bus, run.reference, per_frame=1)
    start = clocks.common_start(run.reference, CYCLE_NS)
    for s in stations:
        if s.has_dc and s.mailbox:
            s.write(0x09A0, struct.pack("<II", CYCLE_NS, 0))
            s.write(0x0990, struct.pack("<Q", start))
            s.write(0x0980, struct.pack("<H", 0x0300))
    for s in stations:
        s.to(SAFE_OP, keep_alive=run.cycle)
    judge.to_operation(run)
    axes = judge.csp_motion(run)
    judge.clocks_in_sync(run)
    judge.demand(all(s.mailbox is None or s.mailbox.number(0x1018, 1) == s.vendor for s in stations), "SDO in OP")
    judge.wind_down(run, axes)
