"""Brings the segment up in the manner of TwinCAT: outputs and inputs by LWR and LRD, the mailbox's state mapped into the
inputs by an FMMU of one bit, complete access tried first, 2 ms cycle, states asked for by broadcast."""
import struct

import clocks
import judge
from coe import Abort
from cyclic import LOGICAL, Cyclic
from station import INIT, PRE_OP, SAFE_OP, all_states, assign_addresses, find_parents
from wire import BRD, BWR, FPRD

CYCLE_NS = 2_000_000

SOURCE = bytes.fromhex("020105104150")  # Ethernet address of its frames


def everyone_to(bus, state, count, run=None):
    import time
    bus.ask(BWR, 0, 0x0120, struct.pack("<H", state))
    end = time.monotonic() + 10
    while all_states(bus) != (state, count):
        if run:
            run.cycle()
        judge.demand(time.monotonic() < end, f"not all in state {state}: {all_states(bus)}")


def assign_by_complete_access(s):
    """1C12h and 1C13h written as a whole, as they were read; one by one where a station refuses that."""
    for index in (0x1C12, 0x1C13):
        pdos = [s.mailbox.number(index, k) for k in range(1, s.mailbox.number(index, 0) + 1)]
        whole = struct.pack("<H", len(pdos)) + b"".join(struct.pack("<H", p) for p in pdos)
        try:
            s.mailbox.download(index, 0, whole, complete=True)
            got = s.mailbox.upload(index, 0, complete=True)
            judge.demand(got == whole, f"station {s.position}: {index:04X}h as a whole is {got.hex()}")
            how = "as a whole"
        except Abort as abort:
            judge.demand(abort.code in (0x06010000, 0x06010003, 0x06010004), f"complete access refused with {abort.code:#x}")
            s.mailbox.put(index, 0, 0, 1)
            for k, pdo in enumerate(pdos):
                s.mailbox.put(index, k + 1, pdo, 2)
            s.mailbox.put(index, 0, len(pdos), 1)
            how = "one by one"
    judge.say(f"ok: station {s.position} takes its assignment {how}")


class WithMailboxBits(Cyclic):
    """The image is followed by one bit a station: its reply mailbox is full."""

    def __init__(self, bus, stations, **more):
        super().__init__(bus, stations, **more)
        self.bits_at = self.size
        self.size += (len(stations) + 7) // 8
        self.image_out, self.image_in = bytearray(self.size), bytes(self.size)
        writers = sum(1 for s in stations if s.out_bytes())
        readers = sum(1 for s in stations if s.in_bytes() or s.mailbox)
        self.expected = (writers, readers)

    def map_bit(self, s):
        s.fmmu(2, LOGICAL + self.bits_at + s.position // 8, 1, 0x080D, 1, bits=(s.position % 8,) * 2, physical_bit=3)

    def mailbox_full(self, s):
        return bool(self.image_in[self.bits_at + s.position // 8] >> s.position % 8 & 1)


def sdo_by_the_mapped_bit(run, s):
    """A request in OP; the reply's arrival is seen in the process data, without a frame of its own."""
    judge.demand(not run.mailbox_full(s), f"station {s.position}: a reply that nobody asked for")
    s.mailbox.send(struct.pack("<HBHBI", 0x2000, 0x40, 0x1018, 1, 0))
    for _ in range(500):
        run.cycle()
        if run.mailbox_full(s):
            break
    judge.demand(run.mailbox_full(s), f"station {s.position}: the mapped bit does not tell the reply")
    kind, body = s.mailbox.receive()
    judge.demand(kind == 3 and struct.unpack_from("<I", body, 6)[0] == s.vendor, f"reply {body.hex()}")
    run.cycle()
    judge.demand(not run.mailbox_full(s), f"station {s.position}: the mailbox was read and still counts as full")


def main(bus, expected):
    count = bus.ask(BRD, 0, 0x0110, 2).wkc
    bus.ask(BWR, 0, 0x0120, bytes([INIT | 0x10, 0]))
    for register, size in ((0x0300, 8), (0x0600, 256), (0x0800, 128), (0x0980, 2)):
        bus.ask(BWR, 0, register, bytes(size))
    stations = assign_addresses(bus, count, 0x03E9, "soem")
    for s in stations:
        s.eeprom.take()
        s.identify()
    find_parents(stations)
    judge.identities(stations, expected)
    for s in stations:
        s.set_up_mailbox()
        s.eeprom.give()
    everyone_to(bus, PRE_OP, count)
    for s in stations:
        if s.mailbox:
            assign_by_complete_access(s)
    judge.pdo_maps(stations, expected)
    for s in stations:
        if s.mailbox:
            for k in s.axes():
                s.mailbox.put(0x6060 + 0x800 * k, 0, 8, 1)
    run = WithMailboxBits(bus, stations, read_write="LRD+LWR", period=CYCLE_NS * 1e-9)
    for s in stations:
        s.set_up_process_sms()
        s.set_up_fmmus(*run.addresses(s))
        if s.mailbox:
            run.map_bit(s)
    run.reference, _ = clocks.latch_and_offset(bus, stations)
    clocks.static_drift(bus, run.reference, per_frame=10)
    start = clocks.common_start(run.reference, CYCLE_NS)
    for s in stations:
        if s.has_dc and s.mailbox:
            clocks.sync0(s, start, CYCLE_NS)
    everyone_to(bus, SAFE_OP, count, run)
    judge.to_operation(run)
    for s in stations:
        if s.mailbox:
            sdo_by_the_mapped_bit(run, s)
    judge.say("ok: replies in OP are seen by their mapped bit")
    axes = judge.csp_motion(run, cycles=1000)
    judge.clocks_in_sync(run)
    judge.wind_down(run, axes)
