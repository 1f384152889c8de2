"""What a master knows of one station, and the single steps of a bring-up that all masters share: AL states, mailbox,
PDO map, SyncManagers, FMMUs. The order of the steps is each master's own (soem.py, igh.py, twincat.py).
"""
import struct
import time

from coe import Mailbox
from sii import Eeprom
from wire import BRD, FPRD, FPWR, BusError

INIT, PRE_OP, BOOT, SAFE_OP, OP = 1, 2, 3, 4, 8
FMMU_OUT, FMMU_IN = 2, 1  # the FMMU's type: write, read


class AlError(Exception):
    def __init__(self, station, wanted, status, code):
        super().__init__(f"station {station}: asked for {wanted}, AL status {status:#x}, code {code:#06x}")
        self.status, self.code = status, code


class Station:
    def __init__(self, bus, position, address, sii_style="soem"):
        self.bus, self.position, self.address = bus, position, address
        self.eeprom = Eeprom(bus, address, sii_style)
        self.sms, self.rx, self.tx = [], [], []   # rx, tx: [(object, sub, bits)]
        self.mailbox = None
        self.in_at = self.out_at = None           # byte offsets in the process image
        self.parent = None

    # --- identity
    def identify(self):
        e = self.eeprom
        self.vendor, self.product, self.revision, self.serial = (e.u32(w) for w in (0x08, 0x0A, 0x0C, 0x0E))
        self.alias = e.u16(0x04)
        self.mailbox_out = (e.u16(0x18), e.u16(0x19))
        self.mailbox_in = (e.u16(0x1A), e.u16(0x1B))
        self.protocols = e.u16(0x1C)
        features = self.read(0x0008, 2).u()
        self.has_dc, self.dc_64 = bool(features & 0x04), bool(features & 0x08)
        self.links = [port for port in range(4) if self.read(0x0110, 2).u() >> 8 + 2 * port & 2]
        self.sii = e.categories()

    def read(self, register, size):
        reply = self.bus.ask(FPRD, self.address, register, size)
        if reply.wkc != 1:
            raise BusError(f"station {self.position}: no answer at {register:#06x} (wkc {reply.wkc})")
        return reply

    def write(self, register, data):
        reply = self.bus.ask(FPWR, self.address, register, data)
        if reply.wkc != 1:
            raise BusError(f"station {self.position}: no write at {register:#06x} (wkc {reply.wkc})")

    # --- states
    def al_status(self):
        raw = self.read(0x0130, 6)
        return raw.u(0, 2), raw.u(4, 2)

    def ask_state(self, state):
        self.write(0x0120, struct.pack("<H", state))

    def wait_state(self, state, timeout=10.0, keep_alive=None):
        end = time.monotonic() + timeout
        while True:
            status, code = self.al_status()
            if status & 0x10:
                raise AlError(self.position, state, status, code)
            if status & 0x0F == state:
                return
            if time.monotonic() > end:
                raise BusError(f"station {self.position}: asked for {state}, still {status:#x} after {timeout} s")
            if keep_alive:
                keep_alive()

    def to(self, state, **kw):
        self.ask_state(state)
        self.wait_state(state, **kw)

    def refusal(self, state, **kw):
        """The AL status code with which the station refuses `state`; None when it does not."""
        try:
            self.to(state, **kw)
        except AlError as error:
            return error.code
        return None

    def acknowledge(self):
        status, _ = self.al_status()
        self.ask_state(status & 0x0F | 0x10)
        self.wait_state(status & 0x0F)

    # --- mailbox
    def sync_manager(self, number, start, length, control, enable=1):
        self.write(0x0800 + 8 * number, struct.pack("<HHBBBB", start, length, control, 0, enable, 0))

    def set_up_mailbox(self):
        """By the EEPROM's SyncManager category, else by its standard mailbox words. False: there is none."""
        if not self.mailbox_out[1]:
            return False
        sms = self.sii["sms"]
        rows = [(*self.mailbox_out, 0x26), (*self.mailbox_in, 0x22)]
        if len(sms) >= 2 and sms[0]["type"] == 1:
            rows = [(sm["start"], sm["length"] or size, sm["control"])
                    for sm, size in zip(sms, (self.mailbox_out[1], self.mailbox_in[1]))]
        for number, (start, length, control) in enumerate(rows):
            self.sync_manager(number, start, length, control)
        self.mailbox = Mailbox(self.bus, self.address, rows[0][:2], rows[1][:2])
        return True

    # --- process data
    def read_pdo_map(self):
        """rx and tx as [(object, sub, bits)]: by CoE where there is a mailbox, else by the EEPROM."""
        if self.mailbox is None:
            self.rx = [e for pdo in self.sii["rx"] if pdo["sm"] < 8 for e in pdo["entries"]]
            self.tx = [e for pdo in self.sii["tx"] if pdo["sm"] < 8 for e in pdo["entries"]]
            return
        self.rx, self.tx = (self._assigned(index) for index in (0x1C12, 0x1C13))

    def _assigned(self, index):
        out = []
        for k in range(1, self.mailbox.number(index, 0) + 1):
            pdo = self.mailbox.number(index, k)
            for n in range(1, self.mailbox.number(pdo, 0) + 1):
                entry = self.mailbox.number(pdo, n)
                out.append((entry >> 16, entry >> 8 & 0xFF, entry & 0xFF))
        return out

    def out_bytes(self):
        return (sum(bits for *_, bits in self.rx) + 7) // 8

    def in_bytes(self):
        return (sum(bits for *_, bits in self.tx) + 7) // 8

    def process_sms(self):
        """(number, start, control) of outputs and inputs by the EEPROM's category; types 3 and 4 (ETG.2010)."""
        found = {}
        for number, sm in enumerate(self.sii["sms"]):
            if sm["type"] in (3, 4):
                found[sm["type"]] = (number, sm["start"], sm["control"])
        return found.get(3), found.get(4)

    def set_up_process_sms(self, out_length=None, in_length=None):
        for row, length in zip(self.process_sms(), (self.out_bytes() if out_length is None else out_length,
                                                    self.in_bytes() if in_length is None else in_length)):
            if row and length:
                self.sync_manager(row[0], row[1], length, row[2])

    def fmmu(self, number, logical, length, physical, kind, bits=(0, 7), physical_bit=0, enable=1):
        self.write(0x0600 + 16 * number,
                   struct.pack("<IHBBHBBB3x", logical, length, bits[0], bits[1], physical, physical_bit, kind, enable))

    def set_up_fmmus(self, out_logical, in_logical):
        out, into = self.process_sms()
        if out and self.out_bytes():
            self.fmmu(0, out_logical, self.out_bytes(), out[1], FMMU_OUT)
        if into and self.in_bytes():
            self.fmmu(1, in_logical, self.in_bytes(), into[1], FMMU_IN)

    def field(self, direction, index, sub=0):
        """(first bit, bits) of an object in the station's outputs ("rx") or inputs ("tx"); None: not mapped."""
        at = 0
        for entry in getattr(self, direction):
            if entry[:2] == (index, sub):
                return at, entry[2]
            at += entry[2]
        return None

    def axes(self):
        """0x800-steps at which a controlword and a target position are mapped (ETG.6010 5.1)."""
        return [k for k in range(8) if self.field("rx", 0x6040 + 0x800 * k) and self.field("rx", 0x607A + 0x800 * k)]


def all_states(bus):
    reply = bus.ask(BRD, 0, 0x0130, 2)
    return reply.u(), reply.wkc


def assign_addresses(bus, count, base, style):
    """Stations 1.. get base, base+1 .. by position."""
    from wire import APWR
    out = []
    for position in range(count):
        if bus.ask(APWR, -position, 0x0010, struct.pack("<H", base + position)).wkc != 1:
            raise BusError(f"no station at position {position}")
        out.append(Station(bus, position, base + position, style))
    return out


def find_parents(stations):
    """Position of the station in front of each (-1: the master), by open ports: a station with one link ends a branch,
    with two it continues, with more it branches (the walk of every master's topology scan)."""
    waiting = []  # [position, branches not yet walked]
    for s in stations:
        while waiting and waiting[-1][1] == 0:
            waiting.pop()
        s.parent = waiting[-1][0] if waiting else -1
        if waiting:
            waiting[-1][1] -= 1
        waiting.append([s.position, len(s.links) - 1])
    return [s.parent for s in stations]
