"""A mailbox master with CoE (ETG.1000.6 5.6): SDO expedited, normal and segmented in both directions, complete access,
SDO information. Counts its own mailboxes, asks for a repeat when a read was lost, takes emergencies at any time.

    box = Mailbox(bus, 0x1001, out=(0x1000, 128), into=(0x1080, 128))
    box.upload(0x1018, 1)                  # bytes
    box.object_list()                      # [index]
"""
import struct
import time

from wire import FPRD, FPWR, BusError

ABORT = 0x80
COE, SDO_REQUEST, SDO_RESPONSE, EMERGENCY, INFORMATION = 3, 2, 3, 1, 8


class Abort(Exception):
    def __init__(self, index, sub, code):
        super().__init__(f"{index:04X}h:{sub} aborted with {code:#010x}")
        self.code = code


class Mailbox:
    def __init__(self, bus, address, out, into, out_sm=0, in_sm=1, timeout=3.0):
        self.bus, self.address, self.out, self.into = bus, address, out, into
        self.out_status, self.in_status = 0x0805 + 8 * out_sm, 0x0805 + 8 * in_sm
        self.counter, self.last_in, self.timeout, self.emergencies = 0, 0, timeout, []

    def _full(self, register):
        reply = self.bus.ask(FPRD, self.address, register, 1)
        return reply.wkc == 1 and bool(reply.u() & 8)

    def send(self, body, kind=COE):
        if 6 + len(body) > self.out[1]:
            raise BusError("request larger than the mailbox")
        self.counter = self.counter % 7 + 1
        raw = struct.pack("<HHBB", len(body), 0, 0, kind | self.counter << 4) + body
        end = time.monotonic() + self.timeout
        while time.monotonic() < end:
            if not self._full(self.out_status):
                if self.bus.ask(FPWR, self.address, self.out[0], raw.ljust(self.out[1], b"\0")).wkc == 1:
                    return
        raise BusError(f"station {self.address:#x} does not empty its mailbox")

    def receive(self):
        """(type, body) of the next mailbox."""
        end = time.monotonic() + self.timeout
        while time.monotonic() < end:
            if not self._full(self.in_status):
                continue
            reply = self.bus.ask(FPRD, self.address, self.into[0], self.into[1])
            if reply.wkc != 1:
                continue
            size, _, _, kind = struct.unpack_from("<HHBB", reply.data)
            if size + 6 > self.into[1]:
                raise BusError(f"mailbox length {size} in {self.into[1]} bytes")
            counter = kind >> 4 & 7
            if counter and counter == self.last_in:
                continue  # the same once more (repeat)
            if counter and self.last_in and counter != self.last_in % 7 + 1:
                raise BusError(f"mailbox counter {counter} after {self.last_in}")
            self.last_in = counter
            if kind & 0xF == 0:
                raise BusError(f"mailbox error reply {reply.data[6:6 + size].hex()}")
            return kind & 0xF, reply.data[6:6 + size]
        raise BusError(f"station {self.address:#x} does not answer its mailbox")

    def _coe(self, service):
        while True:
            kind, body = self.receive()
            if kind != COE or len(body) < 2:
                raise BusError(f"mailbox type {kind}, {len(body)} bytes")
            got = struct.unpack_from("<H", body)[0] >> 12
            if got == EMERGENCY:
                self.emergencies.append(body[2:])
            elif got == service or (service, got) == (SDO_RESPONSE, SDO_REQUEST) and body[2] == ABORT:
                return body[2:]  # an abort travels as a request, also from the station (ETG.1000.6 5.6.2.7)
            else:
                raise BusError(f"CoE service {got}, wanted {service}")

    def _sdo(self, request, index, sub):
        self.send(struct.pack("<H", SDO_REQUEST << 12) + request)
        body = self._coe(SDO_RESPONSE)
        if body[0] == ABORT:
            raise Abort(index, sub, struct.unpack_from("<I", body, 4)[0])
        return body

    def upload(self, index, sub=0, complete=False):
        request = struct.pack("<BHBI", 0x40 | (0x10 if complete else 0), index, sub, 0)
        body = self._sdo(request, index, sub)
        if body[0] >> 5 != 2 or struct.unpack_from("<HB", body, 1) != (index, sub):
            raise BusError(f"upload of {index:04X}h:{sub} answered with {body.hex()}")
        if body[0] & 2:  # expedited
            return body[4:8 - (body[0] >> 2 & 3 if body[0] & 1 else 0)]
        total, = struct.unpack_from("<I", body, 4)
        data, toggle = bytes(body[8:8 + total]), 0
        while len(data) < total:
            part = self._sdo(struct.pack("<B7x", 0x60 | toggle), index, sub)
            if part[0] >> 5 != 0 or part[0] & 0x10 != toggle:
                raise BusError(f"segment answered with {part[0]:#x}, toggle {toggle:#x}")
            room = part[1:]
            data += room[:7 - (part[0] >> 1 & 7)] if len(room) == 7 else room
            toggle ^= 0x10
            if part[0] & 1:
                break
        if len(data) != total:
            raise BusError(f"{index:04X}h:{sub}: {len(data)} bytes of {total}")
        return data

    def download(self, index, sub, value, complete=False):
        flag = 0x10 if complete else 0
        if len(value) <= 4 and not complete:
            body = self._sdo(struct.pack("<BHB", 0x23 | (4 - len(value)) << 2, index, sub) + value.ljust(4, b"\0"), index, sub)
            if body[0] >> 5 != 3:
                raise BusError(f"download of {index:04X}h:{sub} answered with {body.hex()}")
            return
        room = self.out[1] - 6 - 2 - 8
        first, rest = value[:room], value[room:]
        body = self._sdo(struct.pack("<BHBI", 0x21 | flag, index, sub, len(value)) + first, index, sub)
        if body[0] >> 5 != 3:
            raise BusError(f"download of {index:04X}h:{sub} answered with {body.hex()}")
        toggle, room = 0, self.out[1] - 6 - 2 - 1
        while rest:
            part, rest = rest[:room], rest[room:]
            unused = max(0, 7 - len(part))
            head = toggle | unused << 1 | (0 if rest else 1)
            got = self._sdo(bytes([head]) + part.ljust(7, b"\0"), index, sub)
            if got[0] >> 5 != 1 or got[0] & 0x10 != toggle:
                raise BusError(f"segment answered with {got[0]:#x}")
            toggle ^= 0x10

    def number(self, index, sub=0, signed=False):
        return int.from_bytes(self.upload(index, sub), "little", signed=signed)

    def put(self, index, sub, value, size):
        self.download(index, sub, value.to_bytes(size, "little", signed=value < 0))

    def _information(self, opcode, body):
        self.send(struct.pack("<HBBH", INFORMATION << 12, opcode, 0, 0) + body)
        data, first = b"", True
        while True:
            got = self._coe(INFORMATION)
            answer, _, left = struct.unpack_from("<BBH", got)
            if answer & 0x7F == 7:
                raise Abort(0, 0, struct.unpack_from("<I", got, 4)[0])
            if answer & 0x7F != opcode + 1:
                raise BusError(f"SDO information answered with {answer:#x}")
            if bool(answer & 0x80) != bool(left):
                raise BusError("SDO information: 'incomplete' and 'fragments left' disagree")
            data, first = data + got[4:], False
            if not left:
                return data

    def object_list(self, kind=1):
        data = self._information(1, struct.pack("<H", kind))
        if struct.unpack_from("<H", data)[0] != kind or len(data) % 2:
            raise BusError("SDO information: another list than was asked for")
        return list(struct.unpack_from(f"<{len(data) // 2 - 1}H", data, 2))

    def list_lengths(self):
        return struct.unpack("<5H", self._information(1, struct.pack("<H", 0))[2:12])

    def describe(self, index):
        data = self._information(3, struct.pack("<H", index))
        got, kind, subs, code = struct.unpack_from("<HHBB", data)
        if got != index:
            raise BusError(f"description of {got:04X}h instead of {index:04X}h")
        return {"type": kind, "max_sub": subs, "code": code, "name": data[6:].decode("latin-1")}

    def describe_entry(self, index, sub, value_info=0):
        data = self._information(5, struct.pack("<HBB", index, sub, value_info))
        got, at, _, kind, bits, access = struct.unpack_from("<HBBHHH", data)
        if (got, at) != (index, sub):
            raise BusError(f"description of {got:04X}h:{at} instead of {index:04X}h:{sub}")
        return {"type": kind, "bits": bits, "access": access, "name": data[10:].decode("latin-1")}
