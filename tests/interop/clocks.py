"""Distributed clocks as a master sets them up (ETG.1000.4 6.5): latch, delays along the line, offsets, static drift,
SYNC0 from one common start."""
import struct
import time

from wire import BWR, FPRD, FRMW, BusError


def latch_and_offset(bus, stations, epoch_ns=None):
    """Receive times latched by one broadcast, delays from their differences, all clocks on one time. The reference (the
    first station with a clock) and [(station, delay)]."""
    with_clock = [s for s in stations if s.has_dc]
    if not with_clock:
        raise BusError("no station has a clock")
    bus.ask(BWR, 0, 0x0900, bytes(4))
    for s in with_clock:
        s.port_times = [s.read(0x0900 + 4 * port, 4).u() for port in range(4)]
        s.local_ns = s.read(0x0918, 8).u()
    def loop_ns(s):  # from its entry port to the return of its last open port
        last = s.port_times[max(s.links)] if len(s.links) > 1 else s.port_times[0]
        return (last - s.port_times[0]) & 0xFFFFFFFF
    reference = with_clock[0]
    delays = []
    epoch_ns = time.time_ns() - 946684800 * 10**9 if epoch_ns is None else epoch_ns
    for s in with_clock:
        delay = (loop_ns(reference) - loop_ns(s)) // 2
        delays.append((s, delay))
        s.write(0x0920, struct.pack("<Q", (epoch_ns - s.local_ns) & 0xFFFFFFFFFFFFFFFF))
        s.write(0x0928, struct.pack("<I", delay & 0xFFFFFFFF))
    return reference, delays


def static_drift(bus, reference, frames=3000, per_frame=5):
    """The reference's time carried to all (FRMW), often enough for the control loops to settle."""
    for _ in range(frames // per_frame):
        bus.transact([(FRMW, reference.address, 0x0910, bytes(8))] * per_frame)


def difference_ns(station):
    raw = station.read(0x092C, 4).u()
    return -(raw & 0x7FFFFFFF) if raw & 0x80000000 else raw


def common_start(reference, cycle_ns, ahead_ns=300_000_000):
    now = reference.read(0x0910, 8).u()
    return (now + ahead_ns) // cycle_ns * cycle_ns + cycle_ns


def sync0(station, start_ns, cycle_ns):
    station.write(0x0981, b"\0")
    station.write(0x0980, b"\0")
    station.write(0x0990, struct.pack("<Q", start_ns))
    station.write(0x09A0, struct.pack("<I", cycle_ns))
    station.write(0x0981, b"\x03")
