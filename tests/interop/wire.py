"""EtherCAT frames on a network interface, for judges that share nothing with the project: written from ETG.1000.3/.4
and the ET1100 register map. Everything that is sent or heard is kept and can be written as pcapng.

    bus = Wire("gantry-ctl")
    reply = bus.ask(BRD, 0, 0x0000, 2)        # reply.data, reply.wkc
    bus.transact([(LRW, 0x10000, None, image), (FRMW, 0x1001, 0x0910, bytes(8))])
"""
import socket
import struct
import time

NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW = range(15)
ETHERTYPE = 0x88A4
PACKET_IGNORE_OUTGOING = 23
SOL_PACKET = 263


class BusError(Exception):
    """What the segment did is not what the standards say."""


class Reply:
    def __init__(self, data, wkc):
        self.data, self.wkc = data, wkc

    def u(self, at=0, size=None):
        return int.from_bytes(self.data[at:None if size is None else at + size], "little")


def frame_of(datagrams, source, first_index):
    """Ethernet frame of [(command, adp or logical address, ado or None, data)], padded to the shortest length."""
    body = b""
    for i, (command, adp, ado, data) in enumerate(datagrams):
        address = struct.pack("<I", adp) if ado is None else struct.pack("<HH", adp & 0xFFFF, ado)
        more = 0x8000 if i + 1 < len(datagrams) else 0
        body += struct.pack("<BB", command, (first_index + i) & 0xFF) + address
        body += struct.pack("<HH", len(data) | more, 0) + data + b"\0\0"
    frame = b"\xff" * 6 + source + struct.pack(">H", ETHERTYPE) + struct.pack("<H", len(body) | 0x1000) + body
    return frame.ljust(60, b"\0")


def parse(frame):
    """[(command, index, address bytes, data, irq, wkc)]; BusError when lengths do not fit together."""
    if len(frame) < 16 or frame[12:14] != b"\x88\xa4":
        raise BusError("no EtherCAT frame")
    header, = struct.unpack_from("<H", frame, 14)
    if header >> 12 != 1:
        raise BusError(f"EtherCAT type {header >> 12}")
    end, at, out, more = 16 + (header & 0x7FF), 16, [], True
    if end > len(frame):
        raise BusError("EtherCAT length beyond the frame")
    while more:
        if at + 12 > end:
            raise BusError("a datagram beyond the EtherCAT length")
        command, index = frame[at], frame[at + 1]
        length, irq = struct.unpack_from("<HH", frame, at + 6)
        size, more = length & 0x7FF, bool(length & 0x8000)
        if at + 12 + size > end:
            raise BusError("data beyond the EtherCAT length")
        out.append((command, index, frame[at + 2:at + 6], frame[at + 10:at + 10 + size], irq,
                    struct.unpack_from("<H", frame, at + 10 + size)[0]))
        at += 12 + size
    if at != end:
        raise BusError("bytes after the last datagram")
    return out


class Wire:
    def __init__(self, interface, source=b"\x01" * 6, timeout=0.5):
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETHERTYPE))
        self.socket.setsockopt(SOL_PACKET, PACKET_IGNORE_OUTGOING, 1)
        self.socket.bind((interface, ETHERTYPE))
        self.source, self.timeout = source, timeout
        self.index, self.captured, self.keep, self.lost = 0, [], True, 0
        self.worst_turn = self.worst_gap = 0.0  # s; of an answer, and between two cycles

    def transact(self, datagrams, attempts=3):
        """One frame out and back; a lost one is repeated (which a reader of a mailbox must bear, ETG.1000.4 6.6)."""
        datagrams = [(c, a, o, bytes(d) if not isinstance(d, int) else bytes(d)) for c, a, o, d in datagrams]
        for _ in range(attempts):
            first, self.index = self.index, (self.index + len(datagrams)) & 0xFF
            frame = frame_of(datagrams, self.source, first)
            sent = time.monotonic()
            self._note(frame)
            self.socket.send(frame)
            while True:
                left = sent + self.timeout - time.monotonic()
                if left <= 0:
                    break
                self.socket.settimeout(left)
                try:
                    back = self.socket.recv(2048)
                except TimeoutError:
                    break
                self._note(back)
                got = parse(back)
                if [(c, i) for c, i, *_ in got] != [(d[0], (first + k) & 0xFF) for k, d in enumerate(datagrams)]:
                    continue  # the answer to an earlier frame
                if not back[6] & 2:
                    raise BusError("a processed frame without the locally administered bit in its source address")
                if [len(g[3]) for g in got] != [len(d[3]) for d in datagrams]:
                    raise BusError("a datagram changed its length")
                self.worst_turn = max(self.worst_turn, time.monotonic() - sent)
                return [Reply(g[3], g[5]) for g in got]
            self.lost += 1
        raise BusError(f"no answer to {[(c, hex(a), o and hex(o)) for c, a, o, _ in datagrams]}")

    def ask(self, command, adp, ado, data):
        """One datagram; `data` is what to write, or how many bytes to read."""
        return self.transact([(command, adp, ado, data)])[0]

    def _note(self, frame):
        if self.keep:
            self.captured.append((time.time_ns(), frame))

    def write_pcapng(self, path):
        """pcapng (section header, one Ethernet interface in ns, enhanced packets)."""
        def block(kind, body):
            body += bytes(-len(body) % 4)
            return struct.pack("<II", kind, len(body) + 12) + body + struct.pack("<I", len(body) + 12)
        with open(path, "wb") as out:
            out.write(block(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1)))
            options = struct.pack("<HHB3x", 9, 1, 9) + struct.pack("<HH", 0, 0)  # if_tsresol 10^-9
            out.write(block(1, struct.pack("<HHI", 1, 0, 0) + options))
            for when, frame in self.captured:
                head = struct.pack("<IIIII", 0, when >> 32, when & 0xFFFFFFFF, len(frame), len(frame))
                out.write(block(6, head + frame))
