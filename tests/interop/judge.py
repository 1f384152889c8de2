"""What every strange master asks of the segment once it has brought it up: identities, object lists, PDO maps, motion,
clocks. A word on each thing that held; BusError on the first that does not."""
import struct
import time

from clocks import difference_ns
from coe import Abort
from cyclic import CspAxis, until
from station import AlError, OP, SAFE_OP, all_states
from wire import BusError


def say(text):
    print(text, flush=True)


def demand(condition, text):
    if not condition:
        raise BusError(text)


def identities(stations, expected):
    demand(len(stations) == len(expected), f"{len(stations)} stations, {len(expected)} expected")
    for s, e in zip(stations, expected):
        demand((s.vendor, s.product, s.revision) == (e.vendor, e.product, e.revision),
               f"station {s.position} is {s.vendor:#x} {s.product:#x} {s.revision:#x}, expected {e.name}")
        demand(bool(s.mailbox_out[1]) == e.mailbox, f"station {s.position}: mailbox {s.mailbox_out}")
    say(f"ok: {len(stations)} stations are who they should be")


def object_lists(stations, expected):
    """Each object of the profile is listed and described, and the widths tell the truth."""
    for s, e in zip(stations, expected):
        if s.mailbox is None:
            continue
        if not s.sii["general"]["coe"] & 2:
            say(f"not offered: station {s.position} has no SDO information")
            continue
        lengths, listed = s.mailbox.list_lengths(), s.mailbox.object_list()
        demand(lengths[0] == len(listed), f"station {s.position}: list of {len(listed)}, announced {lengths[0]}")
        demand(listed == sorted(set(listed)), f"station {s.position}: object list is not in order")
        missing = {i for i, _ in e.objects} - set(listed)
        demand(not missing, f"station {s.position}: objects not listed: {[f'{i:04X}' for i in sorted(missing)]}")
        read = 0
        for index in listed:
            d = s.mailbox.describe(index)
            for sub in range(d["max_sub"] + 1):
                try:
                    entry = s.mailbox.describe_entry(index, sub)
                except Abort as abort:
                    demand(sub > 0 and abort.code in (0x06090011, 0x06020000), f"{index:04X}h:{sub}: {abort}")
                    continue
                if entry["access"] & 0x3F and entry["access"] & 7:
                    value = s.mailbox.upload(index, sub)
                    read += 1
                    demand(entry["type"] in (9, 10, 11) or 8 * len(value) == (entry["bits"] + 7) // 8 * 8,
                           f"station {s.position}: {index:04X}h:{sub} has {entry['bits']} bits, came as {len(value)} bytes")
        demand(set(s.mailbox.object_list(2)) <= set(listed) and 0x607A in s.mailbox.object_list(2),
               f"station {s.position}: list of RxPDO-mappable objects")
        say(f"ok: station {s.position} lists {len(listed)} objects, {read} values read as described")


def pdo_maps(stations, expected):
    for s, e in zip(stations, expected):
        s.read_pdo_map()
        if s.mailbox is not None:
            out, into = s.process_sms()
            demand(s.rx and s.tx, f"station {s.position} maps nothing")
            demand(len(s.axes()) == e.axes, f"station {s.position} maps {len(s.axes())} axes of {e.axes}")
        say(f"ok: station {s.position} maps {len(s.rx)} outputs ({s.out_bytes()} B), {len(s.tx)} inputs ({s.in_bytes()} B)")


def to_operation(run, timeout=10.0):
    """SAFE_OP to OP with the cycle running."""
    for _ in range(20):
        run.cycle()
    for s in run.stations:
        s.ask_state(OP)
    end = time.monotonic() + timeout
    while run.al != OP:
        run.cycle()
        if run.al & 0x10 or time.monotonic() > end:
            raise BusError(f"not all in OP: {[s.al_status() for s in run.stations]}")
    run.cycle()
    demand(run.wkc == run.expected, f"working counter {run.wkc}, expected {run.expected}")
    say(f"ok: {len(run.stations)} stations in OP, working counter {run.wkc}")


def csp_motion(run, cycles=2000, amplitude=3000):
    """Every axis is enabled, goes `amplitude` counts away and back along a smooth curve, and ends where it began."""
    import math
    axes = [CspAxis(run, s, k) for s in run.stations for k in s.axes()]
    demand(axes, "no axis to move")
    until(run, lambda: all([a.ladder() for a in axes]), "Operation Enabled of every axis", 5000)
    homes = [a.actual() for a in axes]
    wrong = 0
    for n in range(cycles):
        for a, home in zip(axes, homes):
            target = home + round(amplitude * (1 - math.cos(2 * math.pi * (n + 1) / cycles)) / 2)
            a.command(0x0F, target)
        if not run.cycle():
            wrong += 1
        for a, home in zip(axes, homes):
            demand(a.enabled(), f"station {a.station.position}: left Operation Enabled, {a.status():#06x}, cycle {n}")
            a.worst = max(a.worst, abs(a.actual() - a.target))
            a.far = max(getattr(a, "far", 0), a.actual() - home)
    until(run, lambda: all(abs(a.actual() - a.target) <= 2 for a in axes), "the last target reached", 200)
    for a in axes:
        demand(a.far > 0.9 * amplitude, f"station {a.station.position}: went {a.far} of {amplitude} counts")
        states = []
        for word in a.seen:
            state = word & 0x6F
            if state in (0x21, 0x23, 0x27) and state not in states:
                states.append(state)
        demand(states == [0x21, 0x23, 0x27], f"station {a.station.position}: statuswords {[hex(w) for w in a.seen]}")
    demand(wrong == 0, f"{wrong} of {cycles} cycles with a wrong working counter")
    say(f"ok: {len(axes)} axes moved over {cycles} cycles, worst lag {max(a.worst for a in axes)} counts, "
        f"longest gap {1e3 * run.bus.worst_gap:.1f} ms, frames lost {run.bus.lost}")
    return axes


def clocks_in_sync(run, limit_ns=1000):
    worst = max(abs(difference_ns(s)) for s in run.stations if s.has_dc)
    demand(worst < limit_ns, f"clocks differ by {worst} ns")
    say(f"ok: clocks within {worst} ns")


def wind_down(run, axes):
    for a in axes:
        a.disable()
    for _ in range(20):
        run.cycle()
    for s in run.stations:
        s.write(0x0981, b"\0") if s.has_dc else None
        s.ask_state(1)
    end = time.monotonic() + 5
    while all_states(run.bus)[0] != 1:
        demand(time.monotonic() < end, "not all back in INIT")
