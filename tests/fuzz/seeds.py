"""python3 seeds.py: writes the seeds of tests/fuzz/corpus. Small on purpose: libFuzzer keeps what it finds elsewhere."""
import pathlib
import struct

HERE = pathlib.Path(__file__).parent / "corpus"


def seed(target, name, data):
    (HERE / target).mkdir(parents=True, exist_ok=True)
    (HERE / target / name).write_bytes(data)


def datagram(command, adp, ado, data, more=False):
    return struct.pack("<BBHHHH", command, 0, adp & 0xFFFF, ado, len(data) | (0x8000 if more else 0), 0) + data + b"\0\0"


def payload(*datagrams):
    body = b"".join(datagrams)
    return struct.pack("<H", len(body) | 0x1000) + body


INIT, PRE_OP, SAFE_OP, OP = range(4)  # first byte of sim_frame


def frames(*payloads, first=PRE_OP):
    return bytes([first]) + b"".join(struct.pack("<H", len(p)) + p for p in payloads)


def accesses(state, *rows):
    """Datagrams whose headers the target puts right: command, station, register, data, and what time passes before."""
    return bytes([state]) + b"".join(struct.pack("<HBBH", 0x8000 | gap << 12 | len(data), command, station, ado) + data
                                     for command, station, ado, data, gap in ((*r, 0)[:5] for r in rows))


def coe(service, body):
    return bytes(6) + struct.pack("<H", service << 12) + body


def sdo(command, index, sub, value=0):
    return coe(2, struct.pack("<BHBI", command, index, sub, value))


# Replies to a frame of one and of three datagrams: as sent, with a wrong length, a wrong type, nothing at all.
seed("master_frame", "as_sent", bytes([0x80, 7, 0, 0, 4]))
seed("master_frame", "three", bytes([0x82, 9]) + bytes([0, 0, 8, 1, 0, 2, 2, 0, 1]))
seed("master_frame", "sequence", bytes([0xC2, 9]) + bytes([0, 0, 8, 1, 0, 2, 2, 0, 1]))
seed("master_frame", "sequence_differs", bytes([0xC2, 9]) + bytes([0, 0, 8, 1, 0, 2, 2, 0, 1, 0]) + struct.pack("<HB", 26, 0xFF))
seed("master_frame", "cut", bytes([0x80, 7, 0, 0, 100, 3]))
seed("master_frame", "longer", bytes([0x80, 7, 0, 0, 4, 0x84]))
seed("master_frame", "length_changed", bytes([0x80, 7, 0, 0, 4, 0]) + struct.pack("<HB", 22, 0xFF))
seed("master_frame", "counter", bytes([0x80, 7, 0, 0, 4, 0]) + struct.pack("<HB", 34, 1))
seed("master_frame", "late", bytes([0x82, 7, 0, 0, 4, 0, 0, 4, 0, 0, 4, 0]) + struct.pack("<HB", 17, 0xFF))
seed("master_frame", "foreign", bytes([0x00, 7, 0, 0, 4]) + bytes(12) + b"\x88\xa4" + payload(datagram(7, 0, 0, bytes(8))))
seed("master_frame", "empty", bytes([0x00, 7, 0, 0, 4]))


FULL, SHORT, NO_COE, SILENT, NEVER_REPEATS, REFUSES = 1, 2, 4, 8, 16, 32  # kind of station in master_mailbox
EMPTY, NEXT, LOST = 3, 5, 9  # flags of a reply, beside a right header


def replies(what, *rows, flags=1, kind=0):
    """Rows are mailboxes, or pairs of flags and bytes."""
    return bytes([kind, what]) + b"".join(bytes([len(m), f]) + m for f, m in (r if isinstance(r, tuple) else (flags, r) for r in rows))


seed("master_mailbox", "expedited", replies(0, coe(3, struct.pack("<BHBI", 0x43, 0x1018, 1, 0xD28))))
seed("master_mailbox", "normal", replies(0, coe(3, struct.pack("<BHBI", 0x41, 0x1018, 1, 10) + b"0123456789")))
seed("master_mailbox", "segmented", replies(0, coe(3, struct.pack("<BHBI", 0x41, 0x1018, 1, 130) + bytes(100)),
                                            coe(3, b"\x00" + bytes(20)), coe(3, b"\x11" + bytes(10))))
seed("master_mailbox", "abort", replies(0, coe(2, struct.pack("<BHBI", 0x80, 0x1018, 1, 0x06020000))))
seed("master_mailbox", "emergency_first", replies(0, coe(1, struct.pack("<HB5x", 0x8611, 0x21)),
                                                  coe(3, struct.pack("<BHBI", 0x43, 0x1018, 1, 0xD28))))
seed("master_mailbox", "download", replies(1, coe(3, struct.pack("<BHBI", 0x60, 0x607A, 0, 0))))
seed("master_mailbox", "download_segments", replies(2, coe(3, struct.pack("<BHBI", 0x60, 0x2000, 0, 0)), coe(3, b"\x20" + bytes(7)),
                                                    coe(3, b"\x30" + bytes(7)), coe(3, b"\x20" + bytes(7))))
info = lambda op, data, left=0: coe(8, struct.pack("<BBH", op | (0x80 if left else 0), 0, left) + data)
seed("master_mailbox", "complete", replies(3, coe(3, struct.pack("<BHBI", 0x51, 0x1C12, 0, 4) + b"\1\0\0\x16")))
seed("master_mailbox", "list", replies(5, info(2, struct.pack("<HHH", 1, 0x1000, 0x1018), 1), info(2, struct.pack("<H", 0x6040))))
seed("master_mailbox", "describe", replies(6, info(4, struct.pack("<HHBB", 0x6040, 6, 0, 7) + b"controlword")))
seed("master_mailbox", "describe_entry", replies(7, info(6, struct.pack("<HBBHHH", 0x6040, 0, 0, 6, 16, 0x3F) + b"controlword")))
seed("master_mailbox", "whole_list", replies(8, info(2, struct.pack("<HH", 1, 0x6040)), info(4, struct.pack("<HHBB", 0x6040, 6, 0, 7) + b"cw"),
                                             info(6, struct.pack("<HBBHHH", 0x6040, 0, 0, 6, 16, 0x3F) + b"cw")))
seed("master_mailbox", "error_reply", replies(0, struct.pack("<HHBBHH", 4, 0, 0, 0x10, 1, 2), flags=0))
seed("master_mailbox", "lost_read", replies(0, coe(3, struct.pack("<BHBI", 0x43, 0x1018, 1, 1)), flags=3))

identity = coe(3, struct.pack("<BHBI", 0x43, 0x1018, 1, 0xD28))
refused = lambda index, sub, code: coe(2, struct.pack("<BHBI", 0x80, index, sub, code))
one = lambda index, sub, value, size=1: coe(3, struct.pack("<BHBI", 0x43 | (4 - size) << 2, index, sub, value))
seed("master_mailbox", "stale_first", replies(0, (5, identity), (1, coe(1, bytes(8))), identity, kind=FULL))
seed("master_mailbox", "empty_after_all", replies(0, (EMPTY, b""), identity))
seed("master_mailbox", "repeated", replies(0, (LOST, identity), identity))
seed("master_mailbox", "never_repeated", replies(0, (LOST, identity), identity, kind=NEVER_REPEATS))
seed("master_mailbox", "lost_again", replies(0, (LOST, identity), (LOST, identity), (LOST, identity), identity))
seed("master_mailbox", "not_taken", replies(0x10, identity, coe(3, struct.pack("<BHBI", 0x60, 0x607A, 0, 0)), kind=3 * REFUSES))
seed("master_mailbox", "silent", replies(0, (NEXT, coe(1, bytes(8))), kind=SILENT))
seed("master_mailbox", "length_lies", replies(0, (0, struct.pack("<HHBB", 200, 0, 0, 0x13) + bytes(10))))
seed("master_mailbox", "no_coe", replies(5, identity, kind=NO_COE))
seed("master_mailbox", "short_mailbox", replies(0x20, coe(3, struct.pack("<BHBI", 0x41, 0x1018, 1, 20) + bytes(8)), coe(3, b"\x00" + bytes(15)),
                                                coe(3, struct.pack("<BHBI", 0x60, 0x2000, 0, 0)), *(coe(3, bytes([0x20 | n % 2 << 4]) + bytes(7)) for n in range(20)), kind=SHORT))
seed("master_mailbox", "strays", replies(0, *((NEXT, refused(0x2000, 0, 0)) for _ in range(10)), identity))
seed("master_mailbox", "out_of_turn", replies(0, coe(3, struct.pack("<BHBI", 0x41, 0x1018, 1, 130) + bytes(100)), coe(3, b"\x10" + bytes(20))))
seed("master_mailbox", "download_out_of_turn", replies(2, coe(3, struct.pack("<BHBI", 0x60, 0x2000, 0, 0)), coe(3, b"\x30" + bytes(7))))
seed("master_mailbox", "complete_singly", replies(3, refused(0x1C12, 0, 0x06010004), one(0x1C12, 0, 2), one(0x1C12, 1, 0x1600, 2), one(0x1C12, 2, 0x1601, 2)))
seed("master_mailbox", "download_singly", replies(9, refused(0x1C12, 0, 0x06010000)))
done = lambda index, sub: coe(3, struct.pack("<BHBI", 0x60, index, sub, 0))
seed("master_mailbox", "download_complete_singly", replies(4, refused(0x1C12, 0, 0x05040001), *(one(0x1C12, n, 0, 2) for n in (1, 2)), *(done(0x1C12, n) for n in (0, 1, 2, 0))))
seed("master_mailbox", "download_complete", replies(4, coe(3, struct.pack("<BHBI", 0x70, 0x1C12, 0, 0))))
seed("master_mailbox", "number", replies(0xAA, identity, one(0x1018, 1, 7)))
seed("master_mailbox", "information_refused", replies(0x65, info(7, struct.pack("<I", 0x06020000)), refused(0, 0, 0x05040001)))
seed("master_mailbox", "information_strays", replies(6, (NEXT, identity), (NEXT, info(6, bytes(8))), info(4, struct.pack("<HHBB", 0x6041, 6, 0, 7))))
seed("master_mailbox", "information_gaps", replies(8, info(2, struct.pack("<HHH", 1, 0x1018, 0x1008)), info(4, struct.pack("<HHBB", 0x1018, 0x23, 4, 9) + b"identity"),
                                                   info(7, struct.pack("<I", 0x06090011)), info(6, struct.pack("<HBBHHH", 0x1018, 1, 0, 7, 32, 7) + b"vendor")))

words = bytearray(128)
struct.pack_into("<IIII", words, 16, 0xD28, 0x286, 1, 7)
struct.pack_into("<HHHHH", words, 0x30, 0x1000, 128, 0x1080, 128, 4)
struct.pack_into("<HH", words, 0x7C, 15, 1)
strings = bytes([2, 3]) + b"abc" + bytes([4]) + b"defg"
pdo = struct.pack("<HBBBBH", 0x1600, 1, 2, 0, 1, 0) + struct.pack("<HBBBBH", 0x6040, 0, 2, 6, 16, 0)


def category(kind, data):
    data += b"\0" * (len(data) % 2)
    return struct.pack("<HH", kind, len(data) // 2) + data


whole = bytes(words) + category(10, strings) + category(30, bytes(32)) + category(40, b"\1\2\3\0") + \
    category(41, struct.pack("<HHBBBB", 0x1000, 128, 0x26, 0, 1, 1) * 2) + category(51, pdo) + category(60, bytes(24))
READS4, SLOW, ERROR, BUSY, GONE, WORDS, ALL = 1, 2, 4, 8, 12, 16, 32  # first byte of master_sii; the second one is a place, in two words


def eeprom(image, how=0, place=0):
    return bytes([how, place]) + image


seed("master_sii", "whole", eeprom(whole + b"\xff\xff", ALL))
seed("master_sii", "no_end", eeprom(whole))
seed("master_sii", "parser_alone", eeprom(whole, 0))
seed("master_sii", "reads4", eeprom(whole + b"\xff\xff", READS4 | SLOW | WORDS | ALL))
for name, how in (("error", ERROR), ("busy", BUSY), ("gone", GONE)):
    seed("master_sii", name + "_at_once", eeprom(bytes(words), how | WORDS))
    seed("master_sii", name + "_in_categories", eeprom(whole, how | ALL, 0x22))
seed("master_sii", "beyond", eeprom(bytes(words) + struct.pack("<HH", 50, 0x7FFF) + bytes(16)))
seed("master_sii", "words", eeprom(bytes(words)))
seed("master_sii", "short", eeprom(bytes(words[:40])))
seed("master_sii", "general_short", eeprom(bytes(words) + category(30, bytes(4)) + b"\xff\xff"))
seed("master_sii", "pdo_too_many", eeprom(bytes(words) + category(50, struct.pack("<HBBBBH", 0x1A00, 200, 3, 0, 1, 0) + bytes(8)) + b"\xff\xff"))
seed("master_sii", "strings_beyond", eeprom(bytes(words) + category(10, bytes([9, 3]) + b"a\x01\xff" + bytes([200]) + b"abc") + category(50, struct.pack("<HBBBBH", 0x1A00, 1, 3, 0, 1, 0) + struct.pack("<HBBBBH", 0x6041, 0, 1, 6, 16, 0)) + b"\xff\xff"))

seed("sim_frame", "scan", frames(payload(datagram(7, 0, 0, bytes(2))), payload(datagram(2, 0, 0x10, b"\1\x10")),
                                 payload(datagram(4, 0x1001, 0x130, bytes(6))), first=INIT))
seed("sim_frame", "three_in_one", frames(payload(datagram(14, 0x1001, 0x910, bytes(8), True), datagram(12, 0, 1, bytes(16), True),
                                                 datagram(7, 0, 0x130, bytes(2)))))
for n, command in enumerate(("nop", "aprd", "apwr", "aprw", "fprd", "fpwr", "fprw", "brd", "bwr", "brw", "lrd", "lwr", "lrw", "armw", "frmw")):
    seed("sim_frame", command, accesses(n % 4, (n, n % 2, 0x1000 if n < 10 else 0, bytes(6)), (n, 1, 0x0910, bytes(8)), (n, 0, 0x0F00, bytes(4))))
seed("sim_frame", "registers", accesses(OP, *((1, 0, at, bytes(size)) for at, size in (
    (0, 10), (0x10, 4), (0x100, 18), (0x120, 2), (0x130, 6), (0x140, 2), (0x200, 34), (0x300, 20), (0x400, 0x44), (0x500, 16),
    (0x600, 128), (0x800, 64), (0x900, 0xFF), (0xE00, 0x200), (0xF80, 32), (0x2FF0, 16), (0x2FF0, 17)))))
seed("sim_frame", "writes", accesses(PRE_OP, *((2, 0, at, bytes(size)) for at, size in (
    (0x200, 2), (0x300, 8), (0x30C, 1), (0x30D, 3), (0x310, 4), (0x410, 2), (0x420, 2), (0x442, 2), (0x500, 1), (0x8FC, 16), (0xEFC, 8)))))
seed("sim_frame", "loops", accesses(OP, (2, 0, 0x101, b"\x0c"), (7, 0, 0x110, bytes(2)), (2, 0, 0x101, b"\x04"), (7, 0, 0x110, bytes(2)),
                                    (2, 0, 0x101, b"\x10"), (7, 0, 0, bytes(1)), (2, 1, 0x101, b"\x02"), (7, 0, 0, bytes(1))))
seed("sim_frame", "events", accesses(OP, (8, 0, 0x200, b"\xff\xff"), (2, 0, 0x120, b"\4\0"), (7, 0, 0x130, bytes(2), 3), (1, 0, 0x210, bytes(4)),
                                     (7, 0, 0x110, bytes(2))))
seed("sim_frame", "alias", accesses(OP, (2, 0, 0x103, b"\1"), (4, 3, 0x10, bytes(4)), (2, 0, 0x120, b"\x21\0"), (1, 0, 0x130, bytes(6), 2)))
seed("sim_frame", "watchdog", accesses(OP, (2, 0, 0x420, b"\1\0"), (12, 0, 0, bytes(8)), (12, 1, 0, bytes(8)), (7, 0, 0x130, bytes(6), 7),
                                       (2, 0, 0x120, b"\x14\0"), (7, 0, 0x440, bytes(4), 3)))
clocks = ((8, 0, 0x900, bytes(4)), (1, 0, 0x918, bytes(8)), (2, 0, 0x920, struct.pack("<Q", 1000)), (2, 0, 0x928, struct.pack("<I", 600)),
          (2, 1, 0x930, b"\0\x10"))
seed("sim_frame", "clocks", accesses(SAFE_OP, *clocks, *((14, 0, 0x910, bytes(8)) for _ in range(4)), (13, 0, 0x910, bytes(4)), (7, 0, 0x92C, bytes(4))))
start = ((2, 0, 0x9A0, struct.pack("<II", 500000, 0)), (2, 0, 0x990, struct.pack("<Q", 8000000)))
seed("sim_frame", "sync0", accesses(SAFE_OP, *start, (2, 0, 0x980, b"\0\3"), (12, 0, 0, bytes(8), 7), (12, 0, 0, bytes(8), 7), (2, 0, 0x120, b"\x08\0"), (12, 0, 0, bytes(8), 7),
                                    (12, 0, 0, bytes(8), 5), (1, 0, 0x990, bytes(8)), (2, 0, 0x980, b"\0\0"), (7, 0, 0x130, bytes(6), 3)))
seed("sim_frame", "sync1_alone", accesses(PRE_OP, *start, (2, 0, 0x981, b"\5"), (2, 0, 0x120, b"\4\0"), (7, 0, 0x130, bytes(6), 4)))
seed("sim_frame", "no_sync", accesses(SAFE_OP, (2, 0, 0x9A0, struct.pack("<I", 1000000)), (2, 0, 0x990, bytes(8)), (2, 0, 0x981, b"\3"),
                                      (2, 0, 0x120, b"\x08\0"), (7, 0, 0x130, bytes(6), 7), (7, 0, 0x130, bytes(6), 7)))
seed("sim_frame", "no_outputs", accesses(SAFE_OP, (2, 0, 0x120, b"\x08\0"), (7, 0, 0x130, bytes(6), 3), (7, 0, 0x130, bytes(6), 6), (2, 0, 0x120, b"\x14\0")))
seed("sim_frame", "in_step", accesses(SAFE_OP, *(row for n in range(12) for row in ((14, 0, 0x910, bytes(8)), (2, 1, 0x910, struct.pack("<Q", 1000000000 + 100000 * n))))))
seed("sim_frame", "repeat", accesses(PRE_OP, (2, 0, 0x1000, (struct.pack("<HHBB", 10, 0, 0, 0x13) + sdo(0x40, 0x1018, 1)[6:]).ljust(128, b"\0")),
                                     (1, 0, 0x1080, bytes(128)), (2, 0, 0x80E, b"\3"), (1, 0, 0x80E, bytes(2)), (1, 0, 0x1080, bytes(128)), (1, 0, 0x1084, bytes(4))))
seed("sim_frame", "drive", accesses(OP, *((12, 0, 0, struct.pack("<Hi", word, 0), 5) for word in (6, 7, 15, 15, 2, 0, 0x80, 6, 7, 15)),
                                    *((12, 0, 0, struct.pack("<Hi", 15, n * 500), 5) for n in range(8)), (2, 0, 0x120, b"\4\0"), (7, 0, 0x130, bytes(6), 3)))
seed("sim_frame", "states", accesses(INIT, *((8, 0, 0x120, bytes([n, 0]), 3) for n in (2, 3, 0x12, 4, 0x14, 8, 0x18, 7, 0x11, 1))))
seed("sim_frame", "managers", accesses(PRE_OP, (2, 0, 0x800, struct.pack("<HHBBBB", 0x1000, 128, 0x26, 0, 0, 0)), (7, 0, 0x130, bytes(6), 3),
                                       (2, 0, 0x820, struct.pack("<HHBBBB", 0x1090, 64, 0x26, 0, 1, 0)), (2, 0, 0x120, b"\4\0"), (7, 0, 0x130, bytes(6), 3),
                                       (2, 0, 0x818, struct.pack("<HHBBBB", 0x2FF0, 64, 0x20, 0, 1, 0))))
seed("sim_frame", "bit_map", accesses(OP, (2, 0, 0x600, struct.pack("<IHBBHBBB3x", 0, 2, 3, 5, 0x1800, 6, 3, 1)), (12, 0, 0, bytes(4)), (10, 0, 0, bytes(2)),
                                      (11, 0, 1, bytes(1)), (2, 0, 0x610, struct.pack("<IHBBHBBB3x", 2, 1, 0, 0, 0x080D, 0, 1, 1)), (12, 0, 0, bytes(4))))
seed("sim_frame", "mailbox", accesses(PRE_OP, (2, 0, 0x1000, (struct.pack("<HHBB", 10, 0, 0, 0x13) + sdo(0x40, 0x1018, 1)[6:]).ljust(128, b"\0")),
                                      (1, 0, 0x1080, bytes(128)), (1, 0, 0x1080, bytes(1)), (2, 0, 0x1001, bytes(4))))
setup = [datagram(2, 0, 0x10, b"\1\x10"), datagram(2, 0, 0x810, struct.pack("<HHBBBB", 0x1100, 6, 0x64, 0, 1, 0)),
         datagram(2, 0, 0x818, struct.pack("<HHBBBB", 0x1400, 6, 0x20, 0, 1, 0)),
         datagram(2, 0, 0x600, struct.pack("<IHBBHBBB3x", 0x10000, 6, 0, 7, 0x1100, 0, 2, 1)),
         datagram(2, 0, 0x610, struct.pack("<IHBBHBBB3x", 0x10000, 6, 0, 7, 0x1400, 0, 1, 1)),
         datagram(2, 0, 0x9A0, struct.pack("<I", 1000000)), datagram(2, 0, 0x990, struct.pack("<Q", 2000000)),
         datagram(2, 0, 0x980, b"\0\3"), datagram(2, 0, 0x120, b"\4\0"), datagram(12, 0, 1, bytes(6)),
         datagram(2, 0, 0x120, b"\x08\0"), datagram(12, 0, 1, bytes(6)), datagram(1, 0, 0x130, bytes(6))]
seed("sim_frame", "to_op", frames(*[payload(d) for d in setup], first=INIT))
seed("sim_frame", "bits", frames(payload(datagram(2, 0, 0x600, struct.pack("<IHBBHBBB3x", 0x10000, 2, 3, 5, 0x1100, 6, 3, 1))),
                                 payload(datagram(12, 0, 1, bytes(4))), payload(datagram(10, 0xFFFF, 0xFFFF, bytes(4)))))
seed("sim_frame", "lengths_lie", frames(struct.pack("<H", 0x17FF) + bytes(20), payload(datagram(7, 0, 0xFFFF, bytes(9)))))


ID286, AMD530B, STD402EC, AIO4 = range(4)  # kind of station in the first byte of sim_mailbox; its state: << 2
IN_SAFE_OP, IN_OP, ALONE = 2 << 2, 3 << 2, 1 << 4
STATE, REPEAT, PIECE, SAME_COUNTER, POWER = 1 << 4, 2 << 4, 3 << 4, 0x40, 0xB0


def requests(how, *rows, flags=3):
    """Rows are mailboxes, or pairs of flags and bytes."""
    return bytes([how]) + b"".join(bytes([f, len(m)]) + m for f, m in (r if isinstance(r, tuple) else (flags, r) for r in rows))


remap = (sdo(0x2F, 0x1C12, 0, 0), sdo(0x2F, 0x1600, 0, 0), sdo(0x23, 0x1600, 1, 0x60400010), sdo(0x23, 0x1600, 2, 0x607A0020),
         sdo(0x23, 0x1600, 3, 0x60600008), sdo(0x2F, 0x1600, 0, 3), sdo(0x2B, 0x1C12, 1, 0x1600), sdo(0x2F, 0x1C12, 0, 1))
for name, kind in (("id286", ID286), ("amd530b", AMD530B), ("std402ec", STD402EC), ("aio4", AIO4)):
    seed("sim_mailbox", name + "_upload", requests(kind, sdo(0x40, 0x1018, 1), sdo(0x40, 0x1008, 0), sdo(0x60, 0, 0), sdo(0x70, 0, 0), sdo(0x40, 0x6041, 0)))
    seed("sim_mailbox", name + "_mapping", requests(kind, *remap, (STATE, b"\4"), (STATE, b"\x08"), sdo(0x2F, 0x1C12, 0, 0), (STATE, b"\2")))
    seed("sim_mailbox", name + "_complete", requests(kind, sdo(0x50, 0x1C12, 0), sdo(0x31, 0x1C12, 0, 4) + b"\1\0\0\x16", sdo(0x50, 0x1018, 1), sdo(0x50, 0x1C32, 1)))
    seed("sim_mailbox", name + "_information", requests(kind, *(coe(8, struct.pack("<BBHH", 1, 0, 0, n)) for n in range(7)),
         coe(8, struct.pack("<BBHH", 3, 0, 0, 0x6040)), coe(8, struct.pack("<BBHH", 3, 0, 0, 0x1018)), coe(8, struct.pack("<BBHH", 3, 0, 0, 0x1600)),
         coe(8, struct.pack("<BBHHBB", 5, 0, 0, 0x6060, 0, 0x7F)), coe(8, struct.pack("<BBHHBB", 5, 0, 0, 0x1008, 0, 0x7F)), flags=15))
seed("sim_mailbox", "download", requests(ID286, sdo(0x23, 0x607A, 0, 77), sdo(0x2F, 0x6060, 0, 8), sdo(0x2B, 0x6040, 0, 6), sdo(0x22, 0x607A, 0, 1)))
seed("sim_mailbox", "download_normal", requests(ID286, sdo(0x21, 0x607A, 0, 4) + b"\1\2\3\4", sdo(0x21, 0x607A, 0, 8192)))
seed("sim_mailbox", "download_segments", requests(ID286, sdo(0x21, 0x607A, 0, 4), coe(2, b"\x07" + bytes(7)), sdo(0x21, 0x607A, 0, 20),
                                                  coe(2, b"\x00" + bytes(12)), coe(2, b"\x11" + bytes(8))))
seed("sim_mailbox", "download_complete_segments", requests(ID286, sdo(0x21, 0x1C12, 0, 4), sdo(0x31, 0x1C12, 0, 4), coe(2, b"\x07" + b"\1\0\0\x16" + bytes(3))))
seed("sim_mailbox", "upload_segments", requests(STD402EC, sdo(0x50, 0x1C32, 0), sdo(0x50, 0x1A00, 0), sdo(0x60, 0, 0), sdo(0x70, 0, 0), sdo(0x80, 0, 0, 0x05040000)))
seed("sim_mailbox", "toggle", requests(STD402EC, sdo(0x50, 0x1C32, 0), sdo(0x70, 0, 0), sdo(0x21, 0x607A, 0, 30), coe(2, b"\x10" + bytes(7))))
seed("sim_mailbox", "too_short", requests(STD402EC, sdo(0x21, 0x607A, 0, 20), coe(2, b"\x01" + bytes(9)), sdo(0x21, 0x607A, 0, 3), coe(2, b"\x01" + bytes(12))))
seed("sim_mailbox", "information_of_records", requests(STD402EC, *(coe(8, struct.pack("<BBHH", 3, 0, 0, n)) for n in (0x1C00, 0x1C32, 0x1C33, 0x10F1, 0x6099, 0x1000)),
                                                       *(coe(8, struct.pack("<BBHHBB", 5, 0, 0, n, sub, 0x7F)) for n, sub in ((0x1C32, 32), (0x10F1, 2), (0x1018, 1), (0x6060, 9), (0x1C00, 0))), flags=15))
gap = (sdo(0x2F, 0x1C12, 0, 0), sdo(0x2F, 0x1600, 0, 0), sdo(0x23, 0x1600, 1, 3), sdo(0x23, 0x1600, 2, 0x60400010), sdo(0x23, 0x1600, 3, 0x607A0020),
       sdo(0x2F, 0x1600, 0, 3), sdo(0x2B, 0x1C12, 1, 0x1600), sdo(0x2F, 0x1C12, 0, 1))
gap_in = tuple(sdo(c, i + (0x400 if i == 0x1600 else 1), s, v) for c, i, s, v in (
    (0x2F, 0x1C12, 0, 0), (0x2F, 0x1600, 0, 0), (0x23, 0x1600, 1, 5), (0x23, 0x1600, 2, 0x60410010), (0x2F, 0x1600, 0, 2), (0x2B, 0x1C12, 1, 0x1A00), (0x2F, 0x1C12, 0, 1)))
seed("sim_mailbox", "mapping_of_bits", requests(ID286, *gap, *gap_in, (STATE, b"\4"), (STATE, b"\x08"), (STATE, b"\x08")))
seed("sim_mailbox", "mapping_not_allowed", requests(ID286, sdo(0x2F, 0x1600, 0, 0), sdo(0x2F, 0x1C12, 0, 0), sdo(0x2F, 0x1C12, 0, 200), sdo(0x2B, 0x1C12, 1, 0x1A00),
                                                    sdo(0x2F, 0x1600, 0, 0), sdo(0x23, 0x1600, 1, 0x12340010), sdo(0x23, 0x1600, 1, 0x60410010), sdo(0x23, 0x1600, 1, 0x60400910), sdo(0x2F, 0x1600, 0, 200)))
seed("sim_mailbox", "complete_refused", requests(ID286, sdo(0x50, 0x1008, 0), sdo(0x50, 0x1018, 2), sdo(0x50, 0x7777, 0), sdo(0x31, 0x1018, 0, 6) + bytes(6),
                                                 sdo(0x31, 0x10F1, 0, 10) + b"\2\0" + bytes(8), sdo(0x31, 0x10F1, 0, 10) + b"\3\0" + bytes(8), sdo(0x31, 0x1C12, 0, 20) + bytes(20), sdo(0x31, 0x1C12, 1, 2) + b"\0\x16"))
seed("sim_mailbox", "kept", requests(ID286, sdo(0x2B, 0x20C9, 0, 1), sdo(0x2B, 0x20D9, 0, 1), (POWER | 3, sdo(0x40, 0x20C9, 0)), sdo(0x40, 0x20D9, 0)))
seed("sim_mailbox", "store_and_power", requests(AMD530B, sdo(0x2B, 0x6098, 0, 35), sdo(0x23, 0x1010, 1, 0x65766173), (POWER | 3, sdo(0x40, 0x6098, 0))))
seed("sim_mailbox", "alone", requests(STD402EC | ALONE, sdo(0x50, 0x1C32, 0), sdo(0x60, 0, 0), sdo(0x21, 0x607A, 0, 4), coe(2, b"\x07" + bytes(7)), sdo(0x31, 0x1C12, 0, 4) + b"\1\0\0\x16",
                                             coe(8, struct.pack("<BBHH", 1, 0, 0, 1)), (0, struct.pack("<HHBB", 4, 0, 0, 0x73))))
seed("sim_mailbox", "store", requests(AMD530B, sdo(0x23, 0x1010, 1, 0x65766173), sdo(0x23, 0x1010, 2, 0x65766173), sdo(0x23, 0x1010, 1, 0x74736572), sdo(0x23, 0x1010, 1, 1)))
seed("sim_mailbox", "in_op", requests(ID286 | IN_OP, *remap, sdo(0x2B, 0x6040, 0, 6), sdo(0x40, 0x6041, 0)))
seed("sim_mailbox", "in_safe_op", requests(STD402EC | IN_SAFE_OP, *remap, sdo(0x40, 0x6841, 0)))
seed("sim_mailbox", "emergency", requests(ID286, sdo(0x2F, 0x1C12, 0, 0), (STATE | 6, b"\x08"), (STATE | 6, b"\4"), (STATE | 6, b"\x11")))
seed("sim_mailbox", "repeat", requests(ID286, sdo(0x40, 0x1018, 1), (REPEAT | 2, b""), (SAME_COUNTER | 3, sdo(0x40, 0x1018, 1)), (REPEAT | 2, b"")))
seed("sim_mailbox", "pieces", requests(ID286, (PIECE, b"\0\x0a\0\0\0\0\x13"), (PIECE, b"\x7f\0"), (PIECE, b"\x10\1\2")))
seed("sim_mailbox", "not_read", requests(ID286, *((1 | n % 2 * 2, sdo(0x40, 0x1018, n % 5)) for n in range(20))))
seed("sim_mailbox", "wrong", requests(ID286, struct.pack("<HHBB", 200, 0, 0, 0x13), b"\0", bytes([4, 0, 0, 0, 0, 0x1E, 0, 0, 0, 0]), bytes([1, 0, 0, 0, 0, 0x23, 0]), flags=2))
seed("sim_mailbox", "wrong_services", requests(AIO4, coe(3, bytes(8)), coe(8, b"\1"), coe(8, b"\x09\0\0\0\0\0"), coe(2, b"\x40"), sdo(0xE0, 1, 1)))

seed("sim_sii", "read", bytes([5, 2, 5]) + b"\0\1\x08\0\0\0" + bytes([1, 8, 7]) + bytes(8))
seed("sim_sii", "write_alias", bytes([0, 0, 3]) + b"\x34\x12\4\0" + bytes([2, 0, 0, 0]) + bytes([1, 2, 1, 0, 0]))
ask = lambda word, command: bytes([6, 2, 5]) + struct.pack("<HI", command, word)
look = bytes([1, 0, 15]) + bytes(16)
seed("sim_sii", "commands", b"".join(ask(word, command) + look + bytes([4, 0, 3]) + bytes(4) + look
                                     for word, command in ((4, 0x100), (0x7FFFFFFF, 0x100), (0, 0x200), (0, 0x201), (0, 0x300), (0, 0x400), (0, 0))))
seed("sim_sii", "owner", bytes([6, 0, 0, 1]) + ask(0, 0x100) + look + bytes([6, 0, 0, 2]) + ask(0, 0x100) + look)
seed("sim_sii", "damaged", bytes([0, 0, 3]) + b"\xff\xff\0\0" + bytes([4, 0, 3]) + bytes(4) + bytes([2, 0, 0, 0]) + look + bytes([5, 0, 0, 0]) + ask(0, 0) + look)
seed("sim_sii", "off_while_writing", bytes([0x10, 0, 3]) + b"\x34\x12\4\0" + bytes([0x12, 0, 0, 0]) + bytes([0x11]) + look[1:])
seed("sim_sii", "reload", bytes([3, 0, 0, 0, 4, 0, 15]) + bytes(16) + bytes([1, 0, 15]) + bytes(16))
