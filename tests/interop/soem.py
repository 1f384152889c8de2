"""Brings the segment up as masters built on SOEM do: broadcast defaults, 8-byte EEPROM reads, mailbox from the EEPROM,
PDO remapping by CoE, overlapped image, LRW, all stations asked at once."""
import struct

import clocks
import judge
from cyclic import Cyclic
from station import INIT, PRE_OP, SAFE_OP, all_states, assign_addresses, find_parents
from wire import APRD, BRD, BWR, FPRD, FPWR

CYCLE_NS = 1_000_000

SOURCE = b"\x01" * 6  # Ethernet address of its frames


def detect(bus):
    bus.ask(BWR, 0, 0x0103, b"\0")                            # no alias addressing
    for _ in range(2):
        bus.ask(BWR, 0, 0x0120, struct.pack("<H", INIT | 0x10))
    return bus.ask(BRD, 0, 0x0000, 2).wkc


def defaults(bus):
    for register, data in ((0x0101, b"\0"), (0x0200, b"\4\0"), (0x0300, bytes(8)), (0x0600, bytes(48)),
                           (0x0800, bytes(32)), (0x0981, b"\0"), (0x0910, bytes(4)), (0x0930, b"\0\x10"),
                           (0x0934, b"\0\x0c"), (0x0103, b"\0"), (0x0120, bytes([INIT | 0x10, 0])),
                           (0x0500, b"\2"), (0x0500, b"\0")):
        bus.ask(BWR, 0, register, data)


def scan(bus, count):
    for position in range(count):
        bus.ask(APRD, -position, 0x0140, 2)
    stations = assign_addresses(bus, count, 0x1001, "soem")
    for s in stations:
        s.write(0x0100, struct.pack("<H", 1 if s.position == 0 else 0))
        judge.demand(s.read(0x0010, 2).u() == s.address, "address not kept")
        s.read(0x0120, 2)
        s.eeprom.take()
        s.identify()
    judge.demand(find_parents(stations) == list(range(-1, count - 1)), "the stations do not stand in a line")
    judge.say(f"ok: line of {count}, parents {[s.parent for s in stations]}")
    return stations


def pre_op(stations):
    for s in stations:
        has_mailbox = s.set_up_mailbox()
        s.eeprom.give()
        s.ask_state(PRE_OP | 0x10)
        s.wait_state(PRE_OP)
        judge.demand(has_mailbox == (s.mailbox is not None), "mailbox")


def remap(s):
    """Mode, target and controlword; mode display, position, statusword: not the order of the default."""
    if s.mailbox is None:
        return
    for assignment, first, objects in ((0x1C12, 0x1600, ((0x6060, 8), (0x607A, 32), (0x6040, 16))),
                                       (0x1C13, 0x1A00, ((0x6061, 8), (0x6064, 32), (0x6041, 16)))):
        axes = s.mailbox.number(assignment, 0)
        pdos = [s.mailbox.number(assignment, k + 1) for k in range(axes)]
        s.mailbox.put(assignment, 0, 0, 1)
        for k, pdo in enumerate(pdos):
            s.mailbox.put(pdo, 0, 0, 1)
            for n, (index, bits) in enumerate(objects):
                s.mailbox.put(pdo, n + 1, (index + 0x800 * k) << 16 | bits, 4)
            s.mailbox.put(pdo, 0, len(objects), 1)
        for k, pdo in enumerate(pdos):
            s.mailbox.put(assignment, k + 1, pdo, 2)
        s.mailbox.put(assignment, 0, axes, 1)


def main(bus, expected):
    count = detect(bus)
    defaults(bus)
    stations = scan(bus, count)
    judge.identities(stations, expected)
    pre_op(stations)
    judge.pdo_maps(stations, expected)
    judge.object_lists(stations, expected)
    for s in stations:
        remap(s)
    judge.pdo_maps(stations, expected)
    run = Cyclic(bus, stations, read_write="LRW", overlap=True)
    for s in stations:
        s.set_up_process_sms()
        s.set_up_fmmus(*run.addresses(s))
    run.reference, _ = clocks.latch_and_offset(bus, stations)
    clocks.static_drift(bus, run.reference)
    judge.clocks_in_sync(run)
    start = clocks.common_start(run.reference, CYCLE_NS)
    for s in stations:
        if s.has_dc and s.mailbox:
            clocks.sync0(s, start, CYCLE_NS)
    for s in stations:
        s.ask_state(SAFE_OP)
    for s in stations:
        s.wait_state(SAFE_OP, keep_alive=run.cycle)
    judge.demand(all_states(bus) == (SAFE_OP, count), "not all in SAFE_OP")
    judge.to_operation(run)
    axes = judge.csp_motion(run)
    judge.clocks_in_sync(run)
    judge.wind_down(run, axes)
