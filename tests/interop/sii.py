"""The EEPROM of a station (SII, ETG.1000.6 5.4 and ETG.2010), read through the registers 0500h-050Fh in the ways that
masters in the field do.

    eeprom = Eeprom(bus, 0x1001, style="soem")
    eeprom.u32(0x08)                 # vendor
    parsed = eeprom.categories()     # strings, general, fmmu, sync managers, pdos
"""
import struct
import time

from wire import FPRD, FPWR, BusError

BUSY, COMMAND_ERROR, ACK_ERROR, READS_8 = 0x8000, 0x2000, 0x2000, 0x0040


class Eeprom:
    def __init__(self, bus, address, style="soem"):
        self.bus, self.address, self.style, self.cache = bus, address, style, {}

    def _wait(self):
        end = time.monotonic() + 2
        while time.monotonic() < end:
            status = self.bus.ask(FPRD, self.address, 0x0502, 2).u()
            if not status & BUSY:
                return status
        raise BusError(f"station {self.address:#x}: EEPROM busy for 2 s")

    def _fetch(self, word):
        """Reads at `word`; {word: value} of what came, 4 or 8 bytes."""
        if self.style == "igh":
            # Four bytes of command and the low address word; then status, address and data in one read of 10 bytes.
            self.bus.ask(FPWR, self.address, 0x0502, struct.pack("<BBH", 0x80, 0x01, word))
            end = time.monotonic() + 2
            while True:
                reply = self.bus.ask(FPRD, self.address, 0x0502, 10)
                if reply.data[1] & 0x20:
                    raise BusError(f"station {self.address:#x}: EEPROM error, word {word:#x}")
                if reply.wkc == 1 and not reply.data[1] & 0x81:
                    return {word + k: reply.u(6 + 2 * k, 2) for k in range(2)}
                if time.monotonic() > end:
                    raise BusError(f"station {self.address:#x}: EEPROM busy for 2 s")
        status = self._wait()
        if status & 0x7800:
            self.bus.ask(FPWR, self.address, 0x0502, struct.pack("<H", 0))
        self.bus.ask(FPWR, self.address, 0x0502, struct.pack("<HHH", 0x0100, word, 0))
        status = self._wait()
        if status & 0x7800:
            raise BusError(f"station {self.address:#x}: EEPROM status {status:#06x}, word {word:#x}")
        size = 8 if status & READS_8 else 4
        data = self.bus.ask(FPRD, self.address, 0x0508, size)
        return {word + k: data.u(2 * k, 2) for k in range(size // 2)}

    def u16(self, word):
        if word not in self.cache:
            self.cache.update(self._fetch(word))
        return self.cache[word]

    def u32(self, word):
        return self.u16(word) | self.u16(word + 1) << 16

    def take(self):
        """To the master: as SOEM does, by force first."""
        for value in (2, 0):
            self.bus.ask(FPWR, self.address, 0x0500, bytes([value]))

    def give(self):
        """To the station's own application."""
        self.bus.ask(FPWR, self.address, 0x0500, bytes([1]))

    def categories(self):
        return parse_categories(self.u16)


def checksum(words):
    """CRC-8 (x^8+x^2+x+1, start FFh) over the first 14 bytes (ETG.1000.6 5.4)."""
    crc = 0xFF
    for byte in struct.pack("<7H", *words):
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc


def parse_categories(u16, last=0x4000):
    out = {"strings": [], "general": None, "fmmu": [], "sms": [], "tx": [], "rx": [], "order": []}
    at = 0x40
    while True:
        kind = u16(at)
        if kind == 0xFFFF:
            return out
        size = u16(at + 1)
        if at + 2 + size > last:
            raise BusError(f"EEPROM category {kind} beyond the end")
        data = b"".join(struct.pack("<H", u16(at + 2 + i)) for i in range(size))
        out["order"].append(kind)
        if kind == 10:
            out["strings"] = _strings(data)
        elif kind == 30:
            out["general"] = {"name": data[3], "coe": data[5], "foe": data[6], "eoe": data[7], "flags": data[0x0B]}
        elif kind == 40:
            out["fmmu"] = list(data)
        elif kind == 41:
            for sm in range(len(data) // 8):
                start, length, control, _, enable, usage = struct.unpack_from("<HHBBBB", data, 8 * sm)
                out["sms"].append({"start": start, "length": length, "control": control, "enable": enable, "type": usage})
        elif kind in (50, 51):
            out["tx" if kind == 50 else "rx"] = _pdos(data)
        at += 2 + size


def _strings(data):
    out, at = [], 1
    for _ in range(data[0] if data else 0):
        out.append(data[at + 1:at + 1 + data[at]].decode("latin-1"))
        at += 1 + data[at]
    return out


def _pdos(data):
    out, at = [], 0
    while at + 8 <= len(data):
        index, entries, sm, _, _, _ = struct.unpack_from("<HBBBBH", data, at)
        if index == 0:
            break
        at += 8
        rows = []
        for _ in range(entries):
            obj, sub, _, _, bits, _ = struct.unpack_from("<HBBBBH", data, at)
            rows.append((obj, sub, bits))
            at += 8
        out.append({"index": index, "sm": sm, "entries": rows})
    return out
