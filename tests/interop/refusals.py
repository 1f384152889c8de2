"""What a station must refuse, and how (ETG.1000.6 tables of AL status codes and abort codes, ETG.1020): the same
questions to every station of the segment, one after the other."""
import struct
import time

import judge
from coe import Abort
from cyclic import LOGICAL, CspAxis, Cyclic
from soem import defaults, detect, scan
from station import BOOT, INIT, OP, PRE_OP, SAFE_OP
from wire import FPRD, FPWR, LRW, BusError

SOURCE = b"\x01" * 6  # Ethernet address of its frames


def back_to_init(s):
    s.ask_state(INIT | 0x10)
    s.wait_state(INIT)
    s.write(0x0600, bytes(48))
    s.write(0x0800, bytes(32))


def pre_op(s):
    back_to_init(s)
    s.set_up_mailbox()
    s.to(PRE_OP)
    s.read_pdo_map()


def refused(s, state, codes, what):
    before = s.al_status()[0] & 0x0F
    code = s.refusal(state, timeout=5)
    judge.demand(code in codes, f"station {s.position}: {what}: code {code and hex(code)}, expected {[hex(c) for c in codes]}")
    status, _ = s.al_status()
    judge.demand(status & 0x10 and status & 0x0F <= max(before, SAFE_OP if before == OP else before),
                 f"station {s.position}: {what}: AL status {status:#x}")
    s.acknowledge()
    status, code = s.al_status()
    judge.demand(status & 0x10 == 0, f"station {s.position}: {what}: the error stays after it was acknowledged")


def states(s):
    back_to_init(s)
    refused(s, SAFE_OP, (0x11,), "INIT to SAFE_OP")
    refused(s, OP, (0x11,), "INIT to OP")
    refused(s, 0x0F, (0x12,), "an unknown state")
    refused(s, BOOT, (0x13,), "BOOT without a bootstrap mailbox")
    pre_op(s)
    refused(s, OP, (0x11,), "PRE_OP to OP")
    # An error stays until it is acknowledged: a request without the bit is not heard.
    s.refusal(OP)
    s.ask_state(PRE_OP)
    time.sleep(0.05)
    judge.demand(s.al_status()[0] & 0x10, f"station {s.position}: an error went away without acknowledgement")
    s.acknowledge()


def mailbox_set_up(s):
    if not s.mailbox_out[1]:
        return
    for number, (start, length) in ((0, s.mailbox_out), (1, s.mailbox_in)):
        back_to_init(s)
        s.set_up_mailbox()
        s.write(0x0806 + 8 * number, bytes(1))  # where it lies may be written only while it is off (ESC data sheet II)
        s.sync_manager(number, start, 8, 0x26 if number == 0 else 0x22)
        refused(s, PRE_OP, (0x16,), f"SM{number} of 8 bytes")
    back_to_init(s)
    refused(s, PRE_OP, (0x16,), "no mailbox SyncManager")


def process_sms(s):
    out, into = s.out_bytes(), s.in_bytes()
    for what, sizes, codes in (("outputs one byte too long", (out + 1, into), (0x1D,)),
                               ("inputs one byte too long", (out, into + 1), (0x1E,)),
                               ("outputs one byte too short", (max(out - 1, 0), into), (0x1D,)),
                               ("no SyncManagers at all", (0, 0), (0x1D, 0x1E, 0x17))):
        pre_op(s)
        s.set_up_process_sms(*sizes)
        refused(s, SAFE_OP, codes, what)


def no_fmmu(s):
    """Without FMMUs no output ever arrives: OP is not reached, or refused by name."""
    pre_op(s)
    s.set_up_process_sms()
    code = s.refusal(SAFE_OP)
    if code is None:
        s.ask_state(OP)
        end, status, code = time.monotonic() + 6, 0, 0
        while time.monotonic() < end and not status & 0x10:
            s.bus.ask(LRW, LOGICAL, None, 16)
            status, code = s.al_status()
            judge.demand(status & 0x0F != OP, f"station {s.position}: OP without outputs")
            time.sleep(0.002)
    judge.demand(code in (0x1B, 0x19, 0x24, 0x25, 0x26, 0x2D), f"station {s.position}: no FMMU: code {code:#x}")


def sdo(s):
    if s.mailbox is None:
        return
    box = s.mailbox
    def aborts(code, what, call):
        try:
            call()
        except Abort as abort:
            judge.demand(abort.code == code, f"station {s.position}: {what}: {abort.code:#010x}, expected {code:#010x}")
            return
        raise BusError(f"station {s.position}: {what}: not refused")
    aborts(0x06020000, "read of an unknown object", lambda: box.upload(0x5FFF))
    aborts(0x06020000, "write of an unknown object", lambda: box.put(0x5FFF, 0, 1, 4))
    aborts(0x06090011, "unknown subindex", lambda: box.upload(0x1018, 77))
    aborts(0x06010002, "write of a read-only object", lambda: box.put(0x1018, 1, 1, 4))
    aborts(0x06070012, "value too long", lambda: box.put(0x6060, 0, 8, 4))
    aborts(0x06070013, "value too short", lambda: box.put(0x607A, 0, 8, 1))
    aborts(0x06010003, "a mapping that is in use", lambda: box.put(0x1600, 1, 0x60400010, 4))
    # A segment that nobody began, an unknown command.
    for head, what in ((0x60, "a segment out of nowhere"), (0xE0, "an unknown command")):
        box.send(struct.pack("<HB7x", 0x2000, head))
        _, body = box.receive()
        code, = struct.unpack_from("<I", body, 6)
        judge.demand(body[2] == 0x80 and code == 0x05040001, f"station {s.position}: {what}: {body.hex()}")
    judge.demand(box.number(0x1018, 1) == s.vendor, "SDO after refusals")
    # A type that is no protocol of the station, and a length beyond the mailbox: error replies (ETG.1000.4 table 30).
    # These two are wrong on purpose, so the capture that a dissector judges goes without them.
    for length, kind, what in ((4, 0x0E, "an unknown protocol"), (box.out[1], 3, "a length beyond the mailbox")):
        box.counter = box.counter % 7 + 1
        s.bus.keep = False
        raw = struct.pack("<HHBB", length, 0, 0, kind | box.counter << 4) + bytes(4)
        s.bus.ask(FPWR, s.address, box.out[0], raw.ljust(box.out[1], b"\0"))
        s.bus.keep = True
        end = time.monotonic() + 2
        while not box._full(box.in_status):
            judge.demand(time.monotonic() < end, f"station {s.position}: {what}: no error reply")
        data = s.bus.ask(FPRD, s.address, box.into[0], box.into[1]).data
        box.last_in = data[5] >> 4 & 7
        judge.demand(data[5] & 0xF == 0 and struct.unpack_from("<H", data, 6)[0] == 1,
                     f"station {s.position}: {what}: no error reply: {data[:12].hex()}")
        judge.demand(box.number(0x1018, 1) == s.vendor, "SDO after a mailbox error")


def to_op_alone(s):
    pre_op(s)
    if s.mailbox:
        for k in s.axes():
            s.mailbox.put(0x6060 + 0x800 * k, 0, 8, 1)
    run = Cyclic(s.bus, [s])
    s.write(0x0420, struct.pack("<H", 5000))
    s.set_up_process_sms()
    s.set_up_fmmus(*run.addresses(s))
    s.to(SAFE_OP, keep_alive=run.cycle)
    s.ask_state(OP)
    s.wait_state(OP, keep_alive=run.cycle)
    return run


def watchdog(s):
    """Outputs stop: SAFE_OP with 1Bh, drives not enabled; and back to OP in order."""
    run = to_op_alone(s)
    axes = [CspAxis(run, s, k) for k in s.axes()]
    for _ in range(3000):
        run.cycle()
        if all([a.ladder() for a in axes]):
            break
    judge.demand(all(a.enabled() for a in axes), f"station {s.position}: not enabled")
    s.write(0x0420, struct.pack("<H", 500))
    run.cycle()
    stopped, status = time.monotonic(), OP
    while status & 0x0F == OP and time.monotonic() < stopped + 5:
        status, code = s.al_status()
        time.sleep(0.001)
    took = time.monotonic() - stopped
    judge.demand((status, code) == (SAFE_OP | 0x10, 0x1B), f"station {s.position}: AL {status:#x}, code {code:#x}")
    judge.demand(took > 0.045, f"station {s.position}: watchdog of 50 ms after {took:.3f} s")
    judge.demand(s.read(0x0440, 2).u() & 1 == 0, f"station {s.position}: watchdog status says running")
    for a in axes:
        end = time.monotonic() + 5
        while s.mailbox.number(0x6041 + a.base) & 0x6F == 0x27:
            judge.demand(time.monotonic() < end, f"station {s.position}: still enabled without outputs")
    s.acknowledge()
    s.write(0x0420, struct.pack("<H", 5000))
    for a in axes:
        a.command(0, 0)
    run.next = None
    s.ask_state(OP)
    s.wait_state(OP, keep_alive=run.cycle)
    for a in axes:
        judge.demand(not a.enabled(), f"station {s.position}: enabled by itself after the watchdog")
    back_to_init(s)


def main(bus, expected):
    count = detect(bus)
    defaults(bus)
    stations = scan(bus, count)
    for s in stations:
        for question in (states, mailbox_set_up):
            question(s)
        pre_op(s)
        sdo(s)
        process_sms(s)
        no_fmmu(s)
        watchdog(s)
        judge.say(f"ok: station {s.position} refuses what it must")
