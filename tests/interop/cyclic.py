"""A process image over logical addresses, one frame a cycle, with CSP motion of every axis that is mapped.

    run = Cyclic(bus, stations, reference, read_write="LRW")      # or "LRD+LWR"
    run.cycle(); run.expected; run.wkc
"""
import time

from wire import BRD, FRMW, LRD, LRW, LWR, BusError

LOGICAL = 0x01000000


class Cyclic:
    def __init__(self, bus, stations, reference=None, read_write="LRW", overlap=False, period=0.001):
        self.bus, self.stations, self.reference, self.read_write, self.period = bus, stations, reference, read_write, period
        self.size = 0
        for s in stations:
            if overlap:  # outputs and inputs of a station share their logical bytes
                s.out_at = s.in_at = self.size
                self.size += max(s.out_bytes(), s.in_bytes())
            else:
                s.out_at = self.size
                self.size += s.out_bytes()
        if not overlap:
            for s in stations:
                s.in_at = self.size
                self.size += s.in_bytes()
        self.image_out, self.image_in = bytearray(self.size), bytes(self.size)
        writers = sum(1 for s in stations if s.out_bytes())
        readers = sum(1 for s in stations if s.in_bytes())
        self.expected = (writers, readers) if read_write != "LRW" else (2 * writers + readers,)
        self.wkc, self.al, self.dc_ns, self.cycles, self.next = (), 0, 0, 0, None
        self.last_sent = None

    def addresses(self, station):
        return LOGICAL + station.out_at, LOGICAL + station.in_at

    def cycle(self):
        """Waits for the next beat, exchanges. A stall skips beats: no burst."""
        now = time.monotonic()
        self.next = now if self.next is None else self.next + self.period
        if self.next > now:
            time.sleep(self.next - now)
        elif now - self.next > self.period:
            self.next = now
        sent = time.monotonic()
        if self.last_sent:
            self.bus.worst_gap = max(self.bus.worst_gap, sent - self.last_sent)
        self.last_sent = sent
        image = bytes(self.image_out)
        datagrams = [(FRMW, self.reference.address, 0x0910, 8)] if self.reference else []
        if self.read_write == "LRW":
            datagrams += [(LRW, LOGICAL, None, image)]
        else:
            datagrams += [(LWR, LOGICAL, None, image), (LRD, LOGICAL, None, len(image))]
        datagrams += [(BRD, 0, 0x0130, 2)]
        replies = self.bus.transact(datagrams)
        if self.reference:
            self.dc_ns = replies[0].u()
        data = replies[1 if self.reference else 0:-1]
        self.wkc, self.al = tuple(r.wkc for r in data), replies[-1].u()
        if self.wkc == self.expected:
            self.image_in = data[-1].data
        self.cycles += 1
        return self.wkc == self.expected

    def get(self, station, index, sub=0, signed=False):
        at, bits = station.field("tx", index, sub)
        raw = int.from_bytes(self.image_in, "little") >> 8 * station.in_at + at & (1 << bits) - 1
        return raw - (1 << bits) if signed and raw >> bits - 1 else raw

    def put(self, station, index, value, sub=0):
        at, bits = station.field("rx", index, sub)
        at += 8 * station.out_at
        whole, mask = int.from_bytes(self.image_out, "little"), (1 << bits) - 1 << at
        whole = whole & ~mask | (value & (1 << bits) - 1) << at
        self.image_out[:] = whole.to_bytes(self.size, "little")


class CspAxis:
    """One axis of a station: the ladder of CiA 402 by masks of the statusword, then a target that is followed."""

    def __init__(self, run, station, k):
        self.run, self.station, self.base, self.seen = run, station, 0x800 * k, []
        self.home = self.target = 0
        self.worst = 0

    def status(self):
        word = self.run.get(self.station, 0x6041 + self.base)
        if not self.seen or self.seen[-1] != word:
            self.seen.append(word)
        return word

    def actual(self):
        return self.run.get(self.station, 0x6064 + self.base, signed=True)

    def command(self, controlword, target):
        self.run.put(self.station, 0x6040 + self.base, controlword)
        self.run.put(self.station, 0x607A + self.base, target)
        if self.station.field("rx", 0x6060 + self.base):
            self.run.put(self.station, 0x6060 + self.base, 8)
        self.target = target

    def enabled(self):
        return self.status() & 0x6F == 0x27

    def ladder(self):
        """One step towards Operation Enabled; the target stays where the axis is."""
        word = self.status()
        state = word & 0x6F if word & 0x6F in (0x21, 0x23, 0x27) else word & 0x4F
        self.home = self.actual()
        self.command({0x40: 0x06, 0x21: 0x07, 0x23: 0x0F, 0x27: 0x0F, 0x08: 0x80, 0x07: 0x00}.get(state, 0x06), self.home)
        return state == 0x27

    def disable(self):
        self.command(0x06, self.actual())


def until(run, condition, what, cycles=20000):
    for _ in range(cycles):
        run.cycle()
        if condition():
            return
    raise BusError(f"{what}: not within {cycles} cycles (wkc {run.wkc} of {run.expected}, AL {run.al:#x})")
