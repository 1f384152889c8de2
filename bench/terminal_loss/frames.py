"""What a controller commanded and what the stations answered, read from the frames on a cable by ETG.1000.4 alone: where
the outputs and inputs of a station lie is taken from the FMMUs that the frames themselves set up.

    capture = Capture("gantry-ctl")             # the controller's end of the cable
    capture.read()                              # now and then
    for cycle in capture.cycles: cycle.at_ns, cycle.answer, cycle.valve, cycle.axes
"""
import collections
import os
import socket
import struct
import sys

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "../../tests/interop"))
from wire import APWR, FPWR, LRW, LWR, BusError, parse

PACKET_OUTGOING, SOL_PACKET, PACKET_STATISTICS = 4, 263, 6
ETH_P_ALL = 3  # what a host sends is shown to those alone that listen to every protocol
SO_RCVBUFFORCE, SO_TIMESTAMPNS = 33, 35
ADDRESS, FMMU, FMMU_END, FMMU_BYTES = 0x0010, 0x0600, 0x0700, 16
READS, WRITES = 1, 2  # FMMU type: the station's inputs, its outputs
# The PDOs of every drive profile of the reference machine, an axis after the other:
# 6040h u16, 6060h i8, 607Ah i32, 60B8h u16 and 6041h u16, 6061h i8, 6064h i32, 603Fh u16, 60B9h u16, 60BAh i32, 60FDh u32.
OUTPUTS_OF_AXIS, INPUTS_OF_AXIS = 9, 19
COMMANDED = collections.namedtuple("Commanded", "control mode target")
ANSWERED = collections.namedtuple("Answered", "status mode position")
CYCLE = collections.namedtuple("Cycle", "at_ns answer valve axes")


class Capture:
    def __init__(self, interface, io_position, valve_bit):
        self.io_position, self.valve_bit = io_position, valve_bit
        self.socket = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
        self.socket.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 128 << 20)
        self.socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)
        self.socket.bind((interface, ETH_P_ALL))
        self.socket.setblocking(False)
        self.clear()

    def clear(self):
        self.cycles = []
        self.read()
        self.lost()
        self.position_of, self.regions = {}, {}  # of a station's address; (address, FMMU type) -> (logical, bytes)
        self.cycles, self.frames, self.strange = [], 0, 0

    def lost(self):
        """Frames that the kernel could not keep for us since the last time."""
        return struct.unpack("II", self.socket.getsockopt(SOL_PACKET, PACKET_STATISTICS, 8))[1]

    def read(self):
        """Everything that has come."""
        while True:
            try:
                data, control, _, address = self.socket.recvmsg(2048, 64)
            except BlockingIOError:
                return
            at_ns = next((s * 1_000_000_000 + ns for level, kind, body in control if kind == SO_TIMESTAMPNS
                          for s, ns in [struct.unpack("qq", body[:16])]), 0)
            self.dissect(data, at_ns, answer=address[2] != PACKET_OUTGOING)

    def dissect(self, data, at_ns, answer):
        try:
            datagrams = parse(data)
        except BusError:
            self.strange += 1
            return
        self.frames += not answer
        image = {}
        for command, _, address, body, _, _ in datagrams:
            first, second = struct.unpack("<HH", address)
            if command in (LRW, LWR):
                image[first | second << 16] = body
            elif command == APWR and second == ADDRESS and len(body) >= 2 and not answer:
                self.position_of[struct.unpack_from("<H", body)[0]] = -first & 0xFFFF
            elif command == FPWR and FMMU <= second < FMMU_END and not answer:
                self.note_fmmus(first, body)
        if image and self.regions:
            self.cycles.append(CYCLE(at_ns, answer, *self.words(image, answer)))

    def note_fmmus(self, station, body):
        for at in range(0, len(body) - FMMU_BYTES + 1, FMMU_BYTES):
            logical, size, _, _, _, _, kind, active = struct.unpack_from("<IHBBHBBB", body, at)
            if active & 1:
                self.regions[station, kind] = (logical, size)

    def words(self, image, answer):
        """The valve's bit (None where it is not in this image), and each axis' words, by position on the line."""
        valve, axes = None, []
        for station, position in sorted(self.position_of.items(), key=lambda item: item[1]):
            outputs, inputs = self.bytes_of(image, station, WRITES), self.bytes_of(image, station, READS)
            if position == self.io_position:
                valve = bool(outputs[self.valve_bit // 8] >> self.valve_bit % 8 & 1) if outputs else None
            elif answer and inputs:
                axes += [ANSWERED(*struct.unpack_from("<Hbi", inputs, at))
                         for at in range(0, len(inputs) - INPUTS_OF_AXIS + 1, INPUTS_OF_AXIS)]
            elif not answer and outputs:
                axes += [COMMANDED(*struct.unpack_from("<Hbi", outputs, at))
                         for at in range(0, len(outputs) - OUTPUTS_OF_AXIS + 1, OUTPUTS_OF_AXIS)]
        return valve, axes

    def bytes_of(self, image, station, kind):
        logical, size = self.regions.get((station, kind), (0, 0))
        for start, body in image.items():
            if size and start <= logical and logical + size <= start + len(body):
                return body[logical - start:logical - start + size]
        return b""
