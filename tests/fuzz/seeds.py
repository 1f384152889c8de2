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


def frames(*payloads, first=1):
    return bytes([first]) + b"".join(struct.pack("<H", len(p)) + p for p in payloads)


def coe(service, body):
    return bytes(6) + struct.pack("<H", service << 12) + body


def sdo(command, index, sub, value=0):
    return coe(2, struct.pack("<BHBI", command, index, sub, value))


# Replies to a frame of one and of three datagrams: as sent, with a wrong length, a wrong type, nothing at all.
seed("master_frame", "as_sent", bytes([0x80, 7, 0, 0, 4]))
seed("master_frame", "three", bytes([0x82, 9]) + bytes([0, 0, 8, 1, 0, 2, 2, 0, 1]))
seed("master_frame", "length_changed", bytes([0x80, 7, 0, 0, 4]) + struct.pack("<HB", 22, 0xFF))
seed("master_frame", "foreign", bytes([0x00, 7, 0, 0, 4]) + bytes(12) + b"\x88\xa4" + payload(datagram(7, 0, 0, bytes(8))))
seed("master_frame", "empty", bytes([0x00, 7, 0, 0, 4]))


def replies(what, *mailboxes, flags=1):
    return bytes([what]) + b"".join(bytes([len(m), flags]) + m for m in mailboxes)


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
seed("master_sii", "whole", whole + b"\xff\xff")
seed("master_sii", "no_end", whole)
seed("master_sii", "beyond", bytes(words) + struct.pack("<HH", 50, 0x7FFF) + bytes(16))
seed("master_sii", "words", bytes(words))

seed("sim_frame", "scan", frames(payload(datagram(7, 0, 0, bytes(2))), payload(datagram(2, 0, 0x10, b"\1\x10")),
                                 payload(datagram(4, 0x1001, 0x130, bytes(6))), first=0))
seed("sim_frame", "three_in_one", frames(payload(datagram(14, 0x1001, 0x910, bytes(8), True), datagram(12, 0, 1, bytes(16), True),
                                                 datagram(7, 0, 0x130, bytes(2)))))
setup = [datagram(2, 0, 0x10, b"\1\x10"), datagram(2, 0, 0x810, struct.pack("<HHBBBB", 0x1100, 6, 0x64, 0, 1, 0)),
         datagram(2, 0, 0x818, struct.pack("<HHBBBB", 0x1400, 6, 0x20, 0, 1, 0)),
         datagram(2, 0, 0x600, struct.pack("<IHBBHBBB3x", 0x10000, 6, 0, 7, 0x1100, 0, 2, 1)),
         datagram(2, 0, 0x610, struct.pack("<IHBBHBBB3x", 0x10000, 6, 0, 7, 0x1400, 0, 1, 1)),
         datagram(2, 0, 0x9A0, struct.pack("<I", 1000000)), datagram(2, 0, 0x990, struct.pack("<Q", 2000000)),
         datagram(2, 0, 0x980, b"\0\3"), datagram(2, 0, 0x120, b"\4\0"), datagram(12, 0, 1, bytes(6)),
         datagram(2, 0, 0x120, b"\x08\0"), datagram(12, 0, 1, bytes(6)), datagram(1, 0, 0x130, bytes(6))]
seed("sim_frame", "to_op", frames(*[payload(d) for d in setup]))
seed("sim_frame", "bits", frames(payload(datagram(2, 0, 0x600, struct.pack("<IHBBHBBB3x", 0x10000, 2, 3, 5, 0x1100, 6, 3, 1))),
                                 payload(datagram(12, 0, 1, bytes(4))), payload(datagram(10, 0xFFFF, 0xFFFF, bytes(4)))))
seed("sim_frame", "lengths_lie", frames(struct.pack("<H", 0x17FF) + bytes(20), payload(datagram(7, 0, 0xFFFF, bytes(9)))))


def requests(*mailboxes, flags=3):
    return b"".join(bytes([flags, len(m)]) + m for m in mailboxes)


seed("sim_mailbox", "upload", requests(sdo(0x40, 0x1018, 1), sdo(0x40, 0x1008, 0), sdo(0x60, 0, 0), sdo(0x70, 0, 0)))
seed("sim_mailbox", "download", requests(sdo(0x23, 0x607A, 0, 77), sdo(0x2F, 0x6060, 0, 8), sdo(0x2B, 0x6040, 0, 6)))
seed("sim_mailbox", "download_segments", requests(sdo(0x21, 0x607A, 0, 4), coe(2, b"\x01" + bytes(7)), coe(2, b"\x10" + bytes(7))))
seed("sim_mailbox", "mapping", requests(sdo(0x2F, 0x1C12, 0, 0), sdo(0x2F, 0x1600, 0, 0), sdo(0x23, 0x1600, 1, 0x60400010),
                                        sdo(0x2F, 0x1600, 0, 1), sdo(0x2B, 0x1C12, 1, 0x1600), sdo(0x2F, 0x1C12, 0, 1)))
seed("sim_mailbox", "complete_access", requests(sdo(0x50, 0x1C12, 0), sdo(0x31, 0x1C12, 0, 4) + b"\1\0\0\x16", sdo(0x50, 0x1018, 1)))
seed("sim_mailbox", "information", requests(coe(8, struct.pack("<BBHH", 1, 0, 0, 1)), coe(8, struct.pack("<BBHH", 3, 0, 0, 0x6040)),
                                            coe(8, struct.pack("<BBHHBB", 5, 0, 0, 0x6040, 0, 0)), flags=9))
seed("sim_mailbox", "wrong", requests(struct.pack("<HHBB", 200, 0, 0, 0x13), b"\0", bytes([4, 0, 0, 0, 0, 0x1E, 0, 0, 0, 0]), flags=2))

seed("sim_sii", "read", bytes([5, 2, 5]) + b"\0\1\x08\0\0\0" + bytes([1, 8, 7]) + bytes(8))
seed("sim_sii", "write_alias", bytes([0, 0, 3]) + b"\x34\x12\4\0" + bytes([2, 0, 0, 0]) + bytes([1, 2, 1, 0, 0]))
seed("sim_sii", "reload", bytes([3, 0, 0, 0, 4, 0, 15]) + bytes(16) + bytes([1, 0, 15]) + bytes(16))
