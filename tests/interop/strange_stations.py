"""Stations with habits other than those of our own virtual ones, served on an interface until stopped:

    python3 strange_stations.py INTERFACE KIND... [--capture FILE]

Each echoes its outputs inverted in its inputs."""
import dataclasses
import signal
import struct
import sys

from esc import Esc
from sii import checksum
from wire import Wire, parse


@dataclasses.dataclass
class Habits:
    product: int = 1
    mailbox_out: tuple = (0x1000, 128)
    mailbox_in: tuple = (0x1080, 128)
    out_at: int = 0x1100
    in_at: int = 0x1400
    out_sm: int = 2
    in_sm: int = 3
    out_bytes: int = 4
    in_bytes: int = 4
    split: bool = False           # the last half of each direction in a SyncManager of its own (in_sm, in_sm + 1 ...)
    fmmus: int = 3
    lrw: bool = True
    lrw_told: bool = True         # an ESC without LRW says so in 0008h
    dc_bits: int = 0
    drift_ppm: float = 0
    clock_begin_ns: int = 0
    al_s: float = 0.0
    refuse_first_safe_op: bool = False
    sii_8: bool = False
    sii_busy_looks: int = 3
    sii_turned: bool = False      # categories in another order, with one that nobody knows
    emergency_in_sdo: bool = False
    complete_access: bool = False
    starts_in: int = 1            # AL state at power-on
    refuse_pre_op: int = 0        # AL status code
    needs_eeprom: bool = False    # leaves INIT only while its processor has the EEPROM (0500h)
    abort_command: int = 0x80     # of an abort only the upper three bits are fixed
    deaf: bool = False            # takes requests from its mailbox and never answers
    no_eeprom: bool = False       # its EEPROM chip does not acknowledge
    expedited_only: bool = False
    boot_string: bytes = b"a name that does not fit into four bytes"

    def areas(self, outputs):
        """(SyncManager, address, bytes) of one direction."""
        sm, at, size = (self.out_sm, self.out_at, self.out_bytes) if outputs else (self.in_sm, self.in_at, self.in_bytes)
        return [(sm, at, size // 2), (sm + 1, at + 0x20, size - size // 2)] if self.split else [(sm, at, size)]

    @property
    def features(self):
        return (0x04 if self.dc_bits else 0) | (0x08 if self.dc_bits == 64 else 0) | (0 if self.lrw or not self.lrw_told else 0x0200)


KINDS = {
    # large mailboxes far up, EEPROM turned and slow, no clock
    "big_box": Habits(product=0x101, mailbox_out=(0x1800, 1024), mailbox_in=(0x1C00, 1024), sii_turned=True, sii_busy_looks=10),
    # every state takes 300 ms; a 32-bit clock that runs fast
    "slow": Habits(product=0x102, al_s=0.3, dc_bits=32, drift_ppm=30, clock_begin_ns=4_000_000_000),
    # refuses the first SAFE_OP and takes the second
    "capricious": Habits(product=0x103, refuse_first_safe_op=True),
    # LRW passes it by
    "no_lrw": Habits(product=0x104, lrw=False, dc_bits=64, clock_begin_ns=7_000_000),
    # the same, and does not say so
    "hushed": Habits(product=0x10C, lrw=False, lrw_told=False),
    # an emergency in front of every SDO answer, no transfer of more than four bytes
    "nervous": Habits(product=0x105, emergency_in_sdo=True, expedited_only=True, sii_8=True),
    # no mailbox at all; outputs in SM0, inputs in SM1
    "simple": Habits(product=0x106, mailbox_out=(), mailbox_in=(), out_sm=0, in_sm=1, out_at=0x0F00, in_at=0x1000,
                     out_bytes=2, in_bytes=2, dc_bits=64, drift_ppm=-20),
    # a terminal of which each half of the channels has a SyncManager of its own
    "split": Habits(product=0x10B, mailbox_out=(), mailbox_in=(), out_sm=0, in_sm=2, out_at=0x0F00, in_at=0x1000,
                    split=True, fmmus=4),
    # process data elsewhere than its data sheet says (the EEPROM is right), aborts as KickCAT sends them, and an EEPROM
    # that its processor emulates
    "wary": Habits(product=0x10D, out_at=0x1300, in_at=0x1600, needs_eeprom=True, abort_command=0x83),
    # left in BOOT by somebody's firmware update
    "booting": Habits(product=0x107, starts_in=3),
    # never leaves INIT
    "stubborn": Habits(product=0x108, refuse_pre_op=0x0014),
    # takes requests and says nothing
    "deaf": Habits(product=0x109, deaf=True),
    # nobody knows what it is
    "nameless": Habits(product=0x10A, no_eeprom=True),
}


def sii_image(h):
    words = bytearray(128)
    struct.pack_into("<7H", words, 0, 0x0C08, 0, 0, 0, 0, 0, 0)
    struct.pack_into("<H", words, 14, checksum(struct.unpack_from("<7H", words)))
    struct.pack_into("<IIII", words, 16, 0x5A5A, h.product, 3, 99)
    if h.mailbox_out:
        struct.pack_into("<HHHHH", words, 0x30, *h.mailbox_out, *h.mailbox_in, 4)
    struct.pack_into("<HH", words, 0x7C, 15, 1)
    name = b"stranger"
    strings = bytes([1, len(name)]) + name
    general = bytearray(32)
    general[3], general[5] = 1, 0x01 | (0x20 if h.complete_access else 0) if h.mailbox_out else 0
    sms = [struct.pack("<HHBBBB", *h.mailbox_out, 0x26, 0, 1, 1), struct.pack("<HHBBBB", *h.mailbox_in, 0x22, 0, 1, 2)] if h.mailbox_out else []
    sms += [struct.pack("<HHBBBB", at, size, 0x44, 0, 1, 3) for _, at, size in h.areas(True)]
    sms += [struct.pack("<HHBBBB", at, size, 0x00, 0, 1, 4) for _, at, size in h.areas(False)]
    def pdos(index, obj, outputs):
        out, sub = b"", 1
        for n, (sm, _, size) in enumerate(h.areas(outputs)):
            rows = b"".join(struct.pack("<HBBBBH", obj, sub + k, 0, 5, 8, 0) for k in range(size))
            out, sub = out + struct.pack("<HBBBBH", index + n, size, sm, 0, 0, 0) + rows, sub + size
        return out
    categories = [(10, strings), (30, bytes(general)), (40, b"\1\2\3\0"), (41, b"".join(sms)),
                  (50, pdos(0x1A00, 0x6000, False)), (51, pdos(0x1600, 0x7000, True))]
    if h.sii_turned:
        categories = [(0x0802, b"vendor's own")] + categories[::-1]
    out = bytes(words)
    for kind, data in categories:
        data += b"\0" * (len(data) % 2)
        out += struct.pack("<HH", kind, len(data) // 2) + data
    return out + b"\xff\xff"


class Application:
    """The mailbox and the objects of one station."""

    def __init__(self, esc):
        self.esc, self.h, self.counter, self.queue, self.upload = esc, esc.h, 0, [], None
        self.last_request = 0
        h = self.h
        self.objects = {(0x1000, 0): struct.pack("<I", 0x00000191), (0x1018, 0): b"\4", (0x1008, 0): h.boot_string,
                        **{(0x1018, k + 1): struct.pack("<I", v) for k, v in enumerate((0x5A5A, h.product, 3, 99))},
                        (0x1C12, 0): b"\1", (0x1C12, 1): b"\0\x16", (0x1C13, 0): b"\1", (0x1C13, 1): b"\0\x1A",
                        (0x1C00, 0): b"\4", **{(0x1C00, k): bytes([k]) for k in range(1, 5)},
                        (0x1600, 0): bytes([h.out_bytes]), (0x1A00, 0): bytes([h.in_bytes]), (0x2000, 0): b"\0\0"}
        for k in range(h.out_bytes):
            self.objects[(0x1600, k + 1)] = struct.pack("<BBH", 8, k + 1, 0x7000)
        for k in range(h.in_bytes):
            self.objects[(0x1A00, k + 1)] = struct.pack("<BBH", 8, k + 1, 0x6000)
        self.writable = {(0x2000, 0)}
        esc.on_mailbox, esc.on_outputs = self.look, self.echo

    def echo(self):
        h, m = self.h, self.esc.m
        for (_, out_at, size), (_, in_at, _) in zip(h.areas(True), h.areas(False)):
            m[in_at:in_at + size] = bytes(b ^ 0xFF for b in m[out_at:out_at + size])

    def post(self, service, body):
        self.counter = self.counter % 7 + 1
        body = struct.pack("<H", service << 12) + body
        self.queue.append(struct.pack("<HHBB", len(body), 0, 0, 3 | self.counter << 4) + body)

    def look(self):
        esc, h = self.esc, self.h
        if not h.mailbox_out:
            return
        if esc.get(0x0130, 1) & 0x0F < 2:
            self.queue.clear()
            self.last_request = 0
            return
        if esc.m[0x805] & 8:
            raw = bytes(esc.m[h.mailbox_out[0]:sum(h.mailbox_out)])
            esc.m[0x805] &= 0xF7
            size, _, _, kind = struct.unpack_from("<HHBB", raw)
            counter = kind >> 4 & 7
            repeated = counter != 0 and counter == self.last_request  # ETG.1000.4, 5.6: 0 is no counter
            self.last_request = counter or self.last_request
            if kind & 0xF == 3 and not repeated and not h.deaf:
                self.coe(raw[6:6 + size])
        if self.queue and not esc.m[0x80D] & 8 and esc.sm(1)[3]:
            reply = self.queue.pop(0)
            esc.m[h.mailbox_in[0]:sum(h.mailbox_in)] = reply.ljust(h.mailbox_in[1], b"\0")
            esc.m[0x80D] |= 8

    def coe(self, body):
        service = struct.unpack_from("<H", body)[0] >> 12
        if service != 2 or len(body) < 10:
            return
        if self.h.emergency_in_sdo:
            self.post(1, struct.pack("<HB5s", 0x8130, 0x11, b"nerve"))
        command, index, sub, value = struct.unpack_from("<BHBI", body, 2)
        abort = lambda code: self.post(2, struct.pack("<BHBI", self.h.abort_command, index, sub, code))
        known = self.objects.get((index, sub))
        kind = command >> 5
        if kind in (1, 2) and command & 0x10:
            return abort(0x06010004)
        if kind == 2:
            if known is None:
                return abort(0x06090011 if any(i == index for i, _ in self.objects) else 0x06020000)
            if len(known) <= 4:
                return self.post(3, struct.pack("<BHB", 0x43 | (4 - len(known)) << 2, index, sub) + known.ljust(4, b"\0"))
            if self.h.expedited_only:
                return abort(0x08000000)
            return self.post(3, struct.pack("<BHBI", 0x41, index, sub, len(known)) + known)
        if kind == 1:
            if known is None:
                return abort(0x06020000)
            if (index, sub) not in self.writable:
                return abort(0x06010002)
            if not command & 2:
                return abort(0x06010004) if self.h.expedited_only else abort(0x06070010)
            self.objects[(index, sub)] = body[6:10 - (command >> 2 & 3)]
            return self.post(3, struct.pack("<BHBI", 0x60, index, sub, 0))
        if kind == 4:
            return None
        return abort(0x05040001)


def answer(stations, frame):
    """The frame as it comes back from the line."""
    out, at = bytearray(frame), 16
    out[6] |= 2
    for command, _, address, data, _, wkc in parse(frame):
        adp, ado = struct.unpack("<HH", address)
        for esc in stations:
            data, more, adp = esc.serve(command, adp, ado, data)
            wkc += more
        if command not in (10, 11, 12):
            struct.pack_into("<H", out, at + 2, adp)
        out[at + 10:at + 10 + len(data)] = data
        struct.pack_into("<H", out, at + 10 + len(data), wkc & 0xFFFF)
        at += 12 + len(data)
    return bytes(out)


def main():
    arguments = sys.argv[1:]
    capture = arguments[arguments.index("--capture") + 1] if "--capture" in arguments else None
    interface, *kinds = arguments[:arguments.index("--capture")] if capture else arguments
    stations = []
    for n, kind in enumerate(kinds):
        esc = Esc(KINDS[kind], sii_image(KINDS[kind]))
        Application(esc)
        esc.last_port = n + 1 == len(kinds)
        esc.put(0x0110, 0x5001 | 1 << 4 | 1 << 9 | (1 << 10 if esc.last_port else 1 << 5 | 1 << 11), 2)
        stations.append(esc)
    wire = Wire(interface)  # for its socket and its capture
    stop = []
    signal.signal(signal.SIGTERM, lambda *_: stop.append(1))
    print(f"{len(stations)} strange stations on {interface}", flush=True)
    wire.socket.settimeout(0.2)
    while not stop:
        try:
            frame = wire.socket.recv(2048)
        except (TimeoutError, InterruptedError):
            continue
        if capture:
            wire._note(frame)
        back = answer(stations, frame)
        if capture:
            wire._note(back)
        wire.socket.send(back)
    if capture:
        wire.write_pcapng(capture)


if __name__ == "__main__":
    main()
