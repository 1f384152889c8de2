"""A strange station's EtherCAT slave controller in its simplest form (ETG.1000.4, ET1100 registers), for masters that are
to be judged: registers, EEPROM, SyncManagers without a third buffer, FMMUs, AL states, a clock.

    esc = Esc(habits, sii_image);  esc.serve(command, adp, ado, data) -> (data, wkc, adp)
"""
import struct
import time

AP, FP, BC, LOGICAL = (1, 2, 3), (4, 5, 6), (7, 8, 9), (10, 11, 12)


class Esc:
    def __init__(self, habits, sii):
        self.h, self.sii, self.m = habits, bytearray(sii), bytearray(0x3000)
        self.m[0x0000:0x000A] = struct.pack("<BBHBBBBH", 0x04, 1, 3, habits.fmmus, 8, 4, 0x0F, habits.features)
        self.put(0x0012, struct.unpack_from("<H", self.sii, 8)[0], 2)
        self.put(0x0120, habits.starts_in, 2), self.put(0x0130, habits.starts_in, 2)
        self.put(0x0400, 0x09C2, 2), self.put(0x0410, 1000, 2), self.put(0x0420, 1000, 2)
        self.sii_busy, self.al_due, self.al_wanted, self.safe_op_refused = 0, None, 1, False
        self.start, self.adjust_ns, self.last_port = time.monotonic_ns(), 0, True
        self.difference = 0.0
        self.on_mailbox = self.on_outputs = lambda: None
        self.replies = []
        self.wkc_errors = 0

    def put(self, at, value, size):
        self.m[at:at + size] = (value & (1 << 8 * size) - 1).to_bytes(size, "little")

    def get(self, at, size):
        return int.from_bytes(self.m[at:at + size], "little")

    # --- the bus
    def serve(self, command, adp, ado, data):
        """One datagram passing through: (data, what it adds to the working counter, adp)."""
        self.work()
        if command in LOGICAL:
            return (*self.logical(command, adp | ado << 16, data), adp)
        own = {AP: adp == 0, FP: adp == self.get(0x10, 2), BC: True}
        if command in (13, 14):  # ARMW, FRMW: read where addressed, written by all behind
            mine = adp == 0 if command == 13 else adp == self.get(0x10, 2)
            out, ok = self.read(ado, data) if mine else (data, self.write(ado, data))
            return out, int(ok), adp + (command == 13) & 0xFFFF
        kind = next((k for k in own if command in k), None)
        next_adp = adp + 1 & 0xFFFF if kind in (AP, BC) else adp
        if kind is None or not own[kind]:
            return data, 0, next_adp
        action = kind.index(command)  # 0 read, 1 write, 2 both
        out, count = data, 0
        if action in (0, 2):
            got, ok = self.read(ado, data)
            if ok:
                out = bytes(a | b for a, b in zip(got, data)) if kind is BC else got
                count += 1
        if action in (1, 2) and self.write(ado, data):
            count += 1 if action == 1 else 2
        return out, count, next_adp

    def sm(self, i):
        start, length, control, status, activate, pdi = struct.unpack_from("<HHBBBB", self.m, 0x800 + 8 * i)
        return start, length, control, bool(activate & 1)

    def mailbox_sms(self):
        return [i for i in range(8) if self.sm(i)[3] and self.sm(i)[2] & 3 == 2]

    def read(self, ado, data):
        size = len(data)
        if ado + size > len(self.m):
            return data, False
        for i in self.mailbox_sms():
            start, length, control, _ = self.sm(i)
            if ado < start + length and start < ado + size:
                if control & 4 or not self.m[0x805 + 8 * i] & 8 or ado != start:
                    return data, False
                out = bytes(self.m[ado:ado + size])
                if ado + size >= start + length:
                    self.m[0x805 + 8 * i] &= ~8 & 0xFF
                    self.last_read = out
                return out, True
        if ado < 0x0514 and ado + size > 0x0500:
            self.sii_look()
        if ado < 0x0930 and ado + size > 0x0900:
            self.clock_look()
        return bytes(self.m[ado:ado + size]), True

    def write(self, ado, data):
        size = len(data)
        if ado + size > len(self.m):
            return False
        for i in self.mailbox_sms():
            start, length, control, _ = self.sm(i)
            if ado < start + length and start < ado + size:
                if not control & 4 or self.m[0x805 + 8 * i] & 8 or ado != start:
                    return False
                self.m[ado:ado + size] = data
                if ado + size >= start + length:
                    self.m[0x805 + 8 * i] |= 8
                return True
        fixed = ((0x0000, 0x0010), (0x0012, 0x0100), (0x0130, 0x0140), (0x0110, 0x0120), (0x0440, 0x0442))
        for k in range(size):
            at = ado + k
            if any(a <= at < b for a, b in fixed) or 0x800 <= at < 0x840 and at % 8 == 5:
                continue
            if 0x0300 <= at < 0x0314:
                self.m[at] = 0
            elif not (0x0900 <= at < 0x0920 or 0x092C <= at < 0x0930):
                self.m[at] = data[k]
        end = ado + size
        if ado <= 0x0120 < end:
            self.al_request(self.get(0x0120, 2) & 0x1F)
        if ado <= 0x0503 < end or ado <= 0x0502 < end and size > 1:
            self.sii_command()
        if self.h.dc_bits and ado <= 0x0900 < end:
            now = self.local()
            self.put(0x0900, now, 4), self.put(0x0904, now + (0 if self.last_port else 1000), 4), self.put(0x0918, now, self.h.dc_bits // 8)
        if self.h.dc_bits and ado <= 0x0910 < end:
            self.clock_received(int.from_bytes(data[0x0910 - ado:][:self.h.dc_bits // 8], "little"))
        for i in range(8):
            if ado < 0x800 + 8 * i + 8 and 0x800 + 8 * i < end and not self.m[0x806 + 8 * i] & 1:
                self.m[0x805 + 8 * i] = 0
            if ado <= 0x806 + 8 * i < end:  # repeat request: the application answers when it looks
                if (self.m[0x806 + 8 * i] ^ self.m[0x807 + 8 * i]) & 2:
                    self.m[0x807 + 8 * i] ^= 2
                    if getattr(self, "last_read", None) and not self.m[0x805 + 8 * i] & 8:
                        start = self.sm(i)[0]
                        self.m[start:start + len(self.last_read)] = self.last_read
                        self.m[0x805 + 8 * i] |= 8
        return True

    def logical(self, command, address, data):
        if command == 12 and not self.h.lrw:
            return data, 0
        out, read, wrote = bytearray(data), False, False
        for i in range(self.h.fmmus):
            logical, length, first, last, physical, bit, kind, on = struct.unpack_from("<IHBBHBBB", self.m, 0x600 + 16 * i)
            if not on & 1 or (first, last, bit) != (0, 7, 0):
                continue
            low, high = max(address, logical), min(address + len(data), logical + length)
            if low >= high:
                continue
            at = physical + low - logical
            if kind & 2 and command in (11, 12):
                if self.get(0x0130, 1) & 0x0F in (4, 8):
                    self.m[at:at + high - low] = data[low - address:high - address]
                    wrote = True
                    self.on_outputs()
            if kind & 1 and command in (10, 12):
                out[low - address:high - address] = self.m[at:at + high - low]
                read = True
        return bytes(out), (1 if read else 0) + ((2 if command == 12 else 1) if wrote else 0)

    # --- AL states: slow, and capricious where the habits say so
    def al_request(self, wanted):
        status = self.get(0x0130, 2)
        if status & 0x10 and not wanted & 0x10:
            return
        if status & 0x10:
            self.put(0x0130, status & 0x0F, 2), self.put(0x0134, 0, 2)
        self.al_wanted, self.al_due = wanted & 0x0F, time.monotonic() + self.h.al_s

    def refuse(self, state, code):
        self.put(0x0130, state | 0x10, 2), self.put(0x0134, code, 2)

    def work(self):
        """What the station's own processor does between frames."""
        if self.al_due is not None and time.monotonic() >= self.al_due:
            self.al_due = None
            now, wanted = self.get(0x0130, 2) & 0x0F, self.al_wanted
            legal = {3: (1, 3), 1: (1, 2), 2: (1, 2, 4), 4: (1, 2, 4, 8), 8: (1, 2, 4, 8)}
            if wanted not in legal.get(now, ()):
                self.refuse(now, 0x11)
            elif wanted == 4 and now == 2 and self.h.refuse_first_safe_op and not self.safe_op_refused:
                self.safe_op_refused = True
                self.refuse(now, 0x0020)  # "needs cold start", and then does not
            elif wanted == 2 and now == 1 and (code := self.h.refuse_pre_op or self.eeprom_fault() or self.mailbox_fault()):
                self.refuse(now, code)
            elif wanted == 4 and now == 2 and (code := self.process_fault()):
                self.refuse(now, code)
            else:
                self.put(0x0130, wanted, 2), self.put(0x0134, 0, 2)
        self.on_mailbox()

    def eeprom_fault(self):
        return 0x0051 if self.h.needs_eeprom and not self.m[0x0500] & 1 else 0

    def mailbox_fault(self):
        if not self.h.mailbox_out:
            return 0
        return 0 if [self.sm(i)[:2] for i in (0, 1)] == [self.h.mailbox_out, self.h.mailbox_in] else 0x16

    def process_fault(self):
        for outputs, code in ((True, 0x1D), (False, 0x1E)):
            for i, at, size in self.h.areas(outputs):
                if size and (self.sm(i)[:2] != (at, size) or not self.sm(i)[3]):
                    return code
        return 0

    # --- EEPROM
    def sii_command(self):
        command, word = self.m[0x503] & 7, self.get(0x504, 4)
        if command == 1:
            size = 8 if self.h.sii_8 else 4
            data = bytes(self.sii[2 * word:2 * word + size]).ljust(size, b"\xff")
            self.m[0x508:0x508 + size] = b"\xee" * size  # not there yet
            self.sii_busy, self.sii_data = self.h.sii_busy_looks, data
        self.m[0x503] &= 0xF8

    def sii_look(self):
        status = 0x40 if self.h.sii_8 else 0
        if self.sii_busy > 0:
            self.sii_busy -= 1
            status |= 0x8000
        elif getattr(self, "sii_data", None):
            self.m[0x508:0x508 + len(self.sii_data)] = self.sii_data
            self.sii_data = None
        self.put(0x502, status | (0x2000 if self.h.no_eeprom else 0), 2)

    # --- clock
    def local(self):
        ns = time.monotonic_ns() - self.start
        return self.h.clock_begin_ns + ns + int(ns * self.h.drift_ppm * 1e-6)

    def system(self):
        return self.local() + self.get(0x0920, self.h.dc_bits // 8) + int(self.adjust_ns)

    def clock_look(self):
        if self.h.dc_bits:
            self.put(0x0910, self.system(), self.h.dc_bits // 8)
            self.put(0x092C, int(min(abs(self.difference), 2**31 - 1)) | (0x80000000 if self.difference < 0 else 0), 4)

    def clock_received(self, reference):
        bits = self.h.dc_bits
        d = (self.system() - self.get(0x0928, 4) - reference) & (1 << bits) - 1
        d = d - (1 << bits) if d >> bits - 1 else d
        self.adjust_ns -= max(-1000, min(1000, d / 4))
        self.difference = d
