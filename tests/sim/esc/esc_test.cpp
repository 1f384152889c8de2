// The slave controller as a stranger finds it. Expectations are those of the ET1100's register description (ESC data
// sheet, section II) and of the chapters on SyncManagers, FMMUs and the SII (section I); ETG.1000.4 where it says so.
#include "sim/esc/esc.hpp"

#include <gtest/gtest.h>

#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

constexpr std::uint16_t kStation = 0x1001, kSecond = 0x1002;

struct Registers : ::testing::Test {
  config::Machine machine = reference();
  VirtualClock clock;
  Segment segment{machine, clock};
  RawMaster bus{segment, clock};
  void SetUp() override { bus.address_all(); }
  std::uint64_t reg(std::uint16_t at, std::size_t size, std::uint16_t station = kStation) {
    return value(bus.read(station, at, size).data);
  }
};

TEST_F(Registers, tell_what_the_controller_is) {
  EXPECT_EQ(reg(0x0000, 1), 0x11u);          // ET1100
  EXPECT_EQ(reg(0x0004, 1), 8u);             // FMMUs
  EXPECT_EQ(reg(0x0005, 1), 8u);             // SyncManagers
  EXPECT_EQ(reg(0x0006, 1), 8u);             // KiB
  EXPECT_EQ(reg(0x0007, 1), 0x0Fu);          // ports 0 and 1: MII
  EXPECT_EQ(reg(0x0008, 2) & 0x0Cu, 0x0Cu);  // clock, 64 bits
  EXPECT_EQ(reg(0x0100, 4), 0x00070001u);
  EXPECT_EQ(reg(0x0110, 2), 0x5A33u);
  EXPECT_EQ(reg(0x0140, 1), 0x05u);  // SPI
  EXPECT_EQ(reg(0x0400, 2), 2498u);
  EXPECT_EQ(reg(0x0420, 2), 1000u);
  EXPECT_EQ(reg(0x0982, 2), 1000u);  // pulse length, from the SII
}

TEST_F(Registers, that_are_read_only_stay_as_they_are) {
  for (const int number : {0x0000, 0x0004, 0x0008, 0x0012, 0x0041, 0x0110, 0x0130, 0x0134, 0x0140, 0x0204,
                           0x0220, 0x030E, 0x0440, 0x050A, 0x060D, 0x0904, 0x0918, 0x092C, 0x0932, 0x0982,
                           0x098E, 0x0998, 0x09AE, 0x09B0, 0x09C8, 0x0E00, 0x0F04, 0x0F18, 0x0F20}) {
    const auto at = static_cast<std::uint16_t>(number);
    const auto before = reg(at, 2);
    EXPECT_EQ(bus.write(kStation, at, 0x5A5A, 2), 0) << at;
    EXPECT_EQ(reg(at, 2), before) << at;
  }
}

TEST_F(Registers, that_the_bus_may_write_count_and_keep_their_bits) {
  struct Row {
    std::uint16_t at;
    std::size_t size;
    std::uint64_t kept;  // of ones everywhere
  };
  // ESC data sheet, section II: columns "ECAT" of an ET1100 that say r/w, without the bits that are reserved.
  for (const Row& row :
       {Row{0x0108, 2, 0xFFFF}, Row{0x0200, 2, 0xFFFF}, Row{0x0400, 2, 0xFFFF}, Row{0x0410, 2, 0xFFFF},
        Row{0x0420, 2, 0xFFFF}, Row{0x0610, 8, 0x0707FFFFFFFFFFFF}, Row{0x0618, 8, 0x0000000103'07FFFF},
        Row{0x0820, 5, 0x7FFFFFFFFF}, Row{0x0826, 1, 0xC2}, Row{0x0930, 2, 0xFFFF}, Row{0x0934, 1, 0x0F},
        Row{0x0936, 1, 0x01}, Row{0x09A0, 8, 0xFFFFFFFFFFFFFFFF}, Row{0x09A8, 2, 0x0303}, Row{0x0F00, 4, 0xFFFFFFFF},
        Row{0x0F10, 2, 0xFFFF}, Row{0x0F80, 8, 0xFFFFFFFFFFFFFFFF}}) {
    Raw ones(row.size, 0xFF);
    if (row.at == 0x0826) ones[0] = 0xFE;  // not switched on
    EXPECT_EQ(bus.write(kStation, row.at, ones), 1) << std::hex << row.at;
    EXPECT_EQ(reg(row.at, row.size), row.kept) << std::hex << row.at;
  }
  // Reserved bytes beside it take nothing; the datagram counts by what it could write.
  EXPECT_EQ(bus.write(kStation, 0x0F0E, Raw(6, 0x55)), 1);
  EXPECT_EQ(reg(0x0F0E, 6), 0x0000'5555'0000u);
}

TEST_F(Registers, of_the_power_on_values_tell_the_ports) {
  EXPECT_EQ(reg(0x0E00, 2), 0x000Cu);  // ports 0 and 1, both MII
  EXPECT_EQ(reg(0x0008, 2), 0x00FCu);
  EXPECT_EQ(reg(0x0F18, 8), 0u);
}

TEST_F(Registers, under_protection_are_open_for_the_rest_of_a_frame_only) {
  const auto both = [&](std::uint16_t first, std::uint16_t second, std::uint64_t v) {
    Raw f = RawMaster::frame(RawMaster::datagram(5, kStation, first, Raw(1), true) +
                             RawMaster::datagram(5, kStation, second, bytes(v, 2)));
    EXPECT_TRUE(bus.process(f));
    return static_cast<int>(value(f, 27, 2)) * 10 + static_cast<int>(value(f, 41, 2));
  };
  EXPECT_EQ(bus.write(kStation, 0x0021, 1, 1), 1);
  EXPECT_EQ(bus.write(kStation, 0x0410, 7, 2), 0);
  EXPECT_EQ(bus.write(kStation, 0x0021, 0, 1), 0);  // nor can it be taken off without
  EXPECT_EQ(bus.write(kStation, 0x1F00, 7, 2), 1);  // RAM is no register
  EXPECT_EQ(bus.write(kStation, 0x0F80, 7, 2), 1);
  EXPECT_EQ(both(0x0020, 0x0410, 7), 11);  // enabled by any value, here 0
  EXPECT_EQ(reg(0x0410, 2), 7u);
  EXPECT_EQ(reg(0x0020, 2), 0x0100u);  // which is over with its frame
  EXPECT_EQ(bus.write(kStation, 0x0410, 8, 2), 0);
  EXPECT_EQ(both(0x0030, 0x0410, 8), 10);                // the other register takes the write and opens nothing
  EXPECT_EQ(bus.write(kSecond, 0x0410, 8, 2), 1);        // its neighbour is not concerned
  EXPECT_EQ(bus.write(kStation, 0x0020, Raw{1, 0}), 1);  // enabled and taken off by one datagram
  EXPECT_EQ(bus.write(kStation, 0x0410, 9, 2), 1);

  bus.write(kStation, 0x0031, 1, 1);  // all there is
  EXPECT_EQ(bus.write(kStation, 0x1F00, 1, 2), 0);
  EXPECT_EQ(bus.write(kStation, 0x0410, 1, 2), 0);
  EXPECT_EQ(both(0x0020, 0x1F00, 1), 0);
  EXPECT_EQ(both(0x0030, 0x1F00, 3), 11);
  EXPECT_EQ(reg(0x1F00, 2), 3u);
  // Through an FMMU, too.
  EXPECT_EQ(both(0x0030, 0x0031, 0), 11);
  bus.fmmu(kStation, 0, 0x10000, 2, 0x1F00, 2);
  EXPECT_EQ(bus.logical(11, 0x10000, Raw{1, 2}).wkc, 1);
  bus.write(kStation, 0x0031, 1, 1);
  EXPECT_EQ(bus.logical(11, 0x10000, Raw{3, 4}).wkc, 0);
  EXPECT_EQ(reg(0x1F00, 2), 0x0201u);
}

TEST_F(Registers, a_station_restarts_after_r_e_s_in_three_frames) {
  const auto write = [&](char c) { EXPECT_EQ(bus.write(kStation, 0x0040, static_cast<std::uint8_t>(c), 1), 1); };
  write('R');
  EXPECT_EQ(reg(0x0040, 1), 1u);  // progress
  write('E');                     // the look at it was a frame between, which ends the sequence
  EXPECT_EQ(reg(0x0040, 1), 0u);
  write('R'), write('E'), write('R'), write('S');
  EXPECT_EQ(bus.address_all(), 6);
  // All three in one frame are one step at most.
  Raw f = RawMaster::frame(RawMaster::datagram(5, kStation, 0x0040, Raw{'R'}, true) +
                           RawMaster::datagram(5, kStation, 0x0040, Raw{'E'}, true) +
                           RawMaster::datagram(5, kStation, 0x0040, Raw{'S'}));
  EXPECT_TRUE(bus.process(f));
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);

  bus.write(kStation, 0x0410, 7, 2);
  bus.write(0x1003, 0x0410, 7, 2);
  for (const char c : {'R', 'E'}) EXPECT_EQ(bus.write(0x1003, 0x0040, static_cast<std::uint8_t>(c), 1), 1);
  EXPECT_EQ(bus.write(0x1003, 0x0040, 'S', 1), 1);  // this frame still comes round
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 2);      // then the line ends before it
  bus.wait(milliseconds(101));
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
  EXPECT_EQ(bus.read(0x1003, 0x0130, 2).wkc, 0);  // nor does it know its address
  EXPECT_EQ(value(bus.send(1, static_cast<std::uint16_t>(-2), 0x0410, Raw(2)).data), 1000u);
  EXPECT_EQ(reg(0x0410, 2), 7u);
}

TEST_F(Registers, a_read_write_command_writes_at_its_offset) {
  bus.write(kStation, 0x1000, 0x1111, 2);
  bus.write(kStation, 0x0108, 0x0100, 2);
  const Answer a = bus.send(6, kStation, 0x1000, bytes(0x2222, 2));  // FPRW
  EXPECT_EQ(a.wkc, 3);
  EXPECT_EQ(value(a.data), 0x1111u);
  EXPECT_EQ(reg(0x1000, 2), 0x1111u);
  EXPECT_EQ(reg(0x1100, 2), 0x2222u);
  EXPECT_EQ(bus.send(9, 0, 0x1000, bytes(0x4444, 2)).wkc, 3 * 6);  // BRW
  EXPECT_EQ(reg(0x1100, 2), 0x4444u);
  EXPECT_EQ(reg(0x1000, 2, kSecond), 0x5555u);  // no offset there; what came is OR-ed with what the first one had
  EXPECT_EQ(bus.write(kStation, 0x1000, 0x5555, 2), 1);
  EXPECT_EQ(reg(0x1000, 2), 0x5555u);  // a plain write has none
}

TEST_F(Registers, the_alias_answers_when_it_is_enabled) {
  EXPECT_EQ(bus.read(101, 0x0010, 2).wkc, 0);
  bus.write(kSecond, 0x0103, 1, 1);
  EXPECT_EQ(value(bus.read(101, 0x0010, 2).data), kSecond);
}

TEST_F(Registers, of_a_clock_are_absent_where_there_is_none) {
  config::Machine m = one("devices/dio16.yaml", 0);
  m.stations[0].profile.dc = false;
  Segment without(m, clock);
  RawMaster other(without, clock);
  other.address_all();
  EXPECT_EQ(other.read(kStation, 0x0910, 8).wkc, 0);
  EXPECT_EQ(value(other.read(kStation, 0x0008, 2).data) & 0x0Cu, 0u);
}

TEST_F(Registers, error_counters_are_cleared_by_their_groups) {
  segment.faults().corrupt(40);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, -1);
  Raw broken = RawMaster::frame(RawMaster::datagram(7, 0, 0, Raw(64)));
  broken[14] = 0xFF, broken[15] = 0x17;
  bus.process(broken);
  segment.cut_link(1);
  segment.heal_link(1);
  EXPECT_GT(value(bus.read(kStation, 0x0300, 4).data), 0u);
  EXPECT_GT(value(bus.read(0x1006, 0x0308, 1).data), 0u);  // the last one: forwarded errors
  EXPECT_EQ(reg(0x030C, 1), 1u);
  EXPECT_EQ(reg(0x0311, 1), 1u);
  bus.write(kStation, 0x0300, 0x77, 1);
  EXPECT_EQ(reg(0x0300, 8), 0u);
  EXPECT_EQ(reg(0x030C, 1), 1u);
  bus.write(kStation, 0x030C, 0, 1);
  EXPECT_EQ(reg(0x030C, 1), 0u);
  EXPECT_EQ(reg(0x0311, 1), 1u);
  bus.write(kStation, 0x0310, 0, 4);
  EXPECT_EQ(reg(0x0311, 1), 0u);
}

TEST_F(Registers, a_loop_that_is_closed_by_hand_hides_what_is_behind_it) {
  bus.write(0x1003, 0x0101, 0x0C, 1);  // port 1: closed
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 3);
  EXPECT_EQ(reg(0x0110, 2, 0x1003), 0x5633u);  // link, but closed: no communication
  bus.write(0x1003, 0x0101, 0x00, 1);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
  // "Auto close": after a lost link it waits to be told.
  bus.write(0x1003, 0x0101, 0x04, 1);
  segment.cut_link(3);
  segment.heal_link(3);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 3);
  bus.write(0x1003, 0x0101, 0x04, 1);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
  // Opened by hand at the end of the line: frames leave and do not come back.
  bus.write(0x1006, 0x0101, 0x08, 1);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, -1);
}

TEST_F(Registers, events_show_in_every_datagram_under_their_mask) {
  const auto irq = [&] {
    Raw f = RawMaster::frame(RawMaster::datagram(0, 0, 0, Raw(2)));  // NOP
    EXPECT_TRUE(bus.process(f));
    return static_cast<unsigned>(value(f, 24, 2));
  };
  bus.send(7, 0, 0x0110, Raw(2));  // takes the event of the links at power-on back
  EXPECT_EQ(irq(), 0u);
  bus.write(kSecond, 0x0200, 0x0004, 2);
  segment.cut_link(3);
  EXPECT_EQ(irq(), 0u);  // not at this station
  segment.cut_link(2);
  EXPECT_EQ(irq(), 4u);
  EXPECT_EQ(reg(0x0210, 2, kSecond) & 4u, 4u);
  bus.read(kSecond, 0x0110, 2);
  EXPECT_EQ(irq(), 0u);
}

// --- SII

TEST_F(Registers, a_read_of_the_sii_takes_its_time) {
  bus.write(kStation, 0x0502, bytes(0x0100, 2) + bytes(8, 4));
  EXPECT_EQ(reg(0x0502, 2), 0x8140u);  // busy, reading, 8 bytes at once
  // While busy nothing else is taken.
  EXPECT_EQ(bus.write(kStation, 0x0504, bytes(0x40, 4)), 0);
  bus.wait(microseconds(100));
  EXPECT_EQ(reg(0x0502, 2), 0x0040u);
  EXPECT_EQ(reg(0x0508, 4), machine.stations[0].profile.identity.vendor);
  EXPECT_EQ(reg(0x050C, 4), machine.stations[0].profile.identity.product);
}

TEST_F(Registers, a_write_of_the_sii_needs_its_enable_bit_and_outlives_the_supply) {
  bus.write(kStation, 0x0508, 0xBEEF, 2);
  bus.write(kStation, 0x0502, bytes(0x0200, 2) + bytes(0x0400 / 2, 4));
  EXPECT_EQ(reg(0x0502, 2), 0x4040u);  // write not enabled
  bus.write(kStation, 0x0502, 0, 2);
  EXPECT_EQ(reg(0x0502, 2), 0x0040u);
  bus.write(kStation, 0x0508, 0xBEEF, 2);
  bus.write(kStation, 0x0502, bytes(0x0201, 2) + bytes(0x0400 / 2, 4));
  bus.wait(milliseconds(3));
  EXPECT_EQ(reg(0x0502, 2), 0x0040u);
  segment.power_cycle(StationId{0}, milliseconds(10));
  bus.wait(milliseconds(11));
  bus.address_all();
  EXPECT_EQ(bus.sii(kStation, 0x0400 / 2) & 0xFFFF, 0xBEEFu);
}

TEST_F(Registers, the_sii_refuses_what_it_cannot_do) {
  bus.write(kStation, 0x0502, bytes(0x0100, 2) + bytes(0x10000, 4));  // beyond the chip
  bus.wait(milliseconds(1));
  EXPECT_EQ(reg(0x0502, 2), 0x2040u);
  bus.write(kStation, 0x0502, 0x0300, 2);  // read and write at once
  EXPECT_EQ(reg(0x0502, 2), 0x2040u);
  bus.write(kStation, 0x0502, 0, 2);
  EXPECT_EQ(reg(0x0502, 2), 0x0040u);
  bus.write(kStation, 0x0500, 1, 1);  // the station's now
  EXPECT_EQ(bus.write(kStation, 0x0502, bytes(0x0100, 2) + bytes(8, 4)), 0);
  EXPECT_EQ(reg(0x0502, 2), 0x0040u);
  bus.write(kStation, 0x0500, 2, 1);  // taken back, as strangers begin
  EXPECT_EQ(reg(0x0500, 2), 0u);
  EXPECT_EQ(bus.sii(kStation, 8), machine.stations[0].profile.identity.vendor);
}

TEST_F(Registers, a_wrong_checksum_keeps_the_application_from_starting) {
  bus.write(kStation, 0x0508, 0x1234, 2);
  bus.write(kStation, 0x0502, bytes(0x0201, 2) + bytes(4, 4));  // another alias, the old checksum
  bus.wait(milliseconds(3));
  EXPECT_EQ(reg(0x0012, 2), 100u);  // taken at power-on only
  segment.power_cycle(StationId{0}, milliseconds(10));
  bus.wait(milliseconds(11));
  bus.address_all();
  EXPECT_EQ(reg(0x0502, 2), 0x1840u);               // checksum, not loaded
  EXPECT_EQ(reg(0x0110, 2) & 1u, 0u);               // not operational
  EXPECT_EQ(bus.read(kStation, 0x1000, 2).wkc, 0);  // and no process RAM
  EXPECT_EQ(bus.write(kStation, 0x1000, 1, 2), 0);
  EXPECT_EQ(bus.write(kStation, 0x0F80, 1, 2), 1);
  bus.mailboxes(kStation);
  EXPECT_EQ(bus.request(kStation, 2), 0x11);
  EXPECT_EQ(bus.status_code(kStation), 0x51);
}

// --- SyncManagers

TEST_F(Registers, a_sync_manager_moves_only_while_it_is_off) {
  bus.sync_manager(kStation, 4, 0x1800, 16, 0x26);
  bus.write(kStation, 0x0820, bytes(0x1900, 2) + bytes(32, 2) + Raw{0x64});
  EXPECT_EQ(reg(0x0820, 5), 0x2600101800u);
  bus.write(kStation, 0x0820, Raw(8));  // strangers clear all eight bytes at once: that switches it off
  EXPECT_EQ(reg(0x0826, 1), 0u);
  bus.write(kStation, 0x0820, Raw(8));
  EXPECT_EQ(reg(0x0820, 5), 0u);
}

TEST_F(Registers, a_mailbox_opens_with_its_first_byte_and_hands_over_with_its_last) {
  bus.sync_manager(kStation, 0, 0x1000, 128, 0x26);
  bus.sync_manager(kStation, 1, 0x1080, 128, 0x22);
  EXPECT_EQ(bus.write(kStation, 0x1000, Raw(128)), 0);  // INIT: the station keeps it closed
  EXPECT_EQ(reg(0x0807, 1), 1u);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  EXPECT_EQ(reg(0x0807, 1), 0u);
  EXPECT_EQ(bus.write(kStation, 0x1010, 1, 1), 0);  // not from the middle
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x13} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  EXPECT_EQ(bus.write(kStation, 0x1000, request), 1);
  EXPECT_EQ(reg(0x0805, 1) & 8u, 0u);
  EXPECT_EQ(reg(0x080D, 1) & 8u, 0u);
  EXPECT_EQ(bus.write(kStation, 0x107F, 0, 1), 1);  // the last byte
  EXPECT_EQ(reg(0x080D, 1) & 8u, 8u);               // answered
  EXPECT_EQ(bus.read(kStation, 0x1081, 1).wkc, 0);
  EXPECT_EQ(bus.read(kStation, 0x1080, 6).wkc, 1);
  EXPECT_EQ(reg(0x080D, 1) & 8u, 8u);
  EXPECT_EQ(bus.read(kStation, 0x10FF, 1).wkc, 1);
  EXPECT_EQ(reg(0x080D, 1) & 8u, 0u);
  EXPECT_EQ(bus.read(kStation, 0x1080, 128).wkc, 0);
}

TEST_F(Registers, process_data_changes_hands_as_a_whole) {
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  bus.sync_manager(kStation, 2, 0x1100, 6, 0x64);
  bus.sync_manager(kStation, 3, 0x1400, 6, 0x20);
  EXPECT_EQ(bus.read(kStation, 0x1400, 6).wkc, 0);  // PRE_OP: closed
  EXPECT_EQ(bus.write(kStation, 0x1100, Raw(6)), 0);
  ASSERT_EQ(bus.request(kStation, 4), 4);
  EXPECT_EQ(bus.read(kStation, 0x1400, 6).wkc, 1);
  EXPECT_EQ(bus.read(kStation, 0x1100, 6).wkc, 0);  // an output is not read back
  EXPECT_EQ(bus.write(kStation, 0x1400, Raw(6)), 0);
  EXPECT_EQ(bus.write(kStation, 0x1100, Raw{6, 0, 1, 2}), 1);  // not whole: nobody sees it
  ASSERT_EQ(bus.request(kStation, 8), 4);
  EXPECT_EQ(reg(0x0815, 1) >> 4 & 3u, 3u);  // no buffer written
  EXPECT_EQ(bus.write(kStation, 0x1104, Raw{3, 4}), 1);
  EXPECT_EQ(bus.state(kStation), 8);
  bus.wait(milliseconds(1));
  segment.advance();
  EXPECT_EQ(segment.station(0).objects().value({0x607A, 0}), 0x04030201);
  // Input bytes of one read belong to one instant.
  EXPECT_EQ(bus.read(kStation, 0x1402, 1).wkc, 0);
  EXPECT_EQ(bus.read(kStation, 0x1400, 1).wkc, 1);
  EXPECT_EQ(bus.read(kStation, 0x1402, 4).wkc, 1);
  EXPECT_EQ(bus.read(kStation, 0x1402, 1).wkc, 0);  // closed again
}

TEST_F(Registers, an_fmmu_shows_a_mailboxs_flag_as_a_bit) {
  // As TwinCAT does: bit 3 of 080Dh at a bit of the logical space.
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  bus.write(kStation, 0x0620, bytes(0x9000000, 4) + bytes(1, 2) + Raw{2, 2} + bytes(0x080D, 2) + Raw{3, 1, 1, 0, 0, 0});
  EXPECT_EQ(bus.logical(10, 0x9000000, Raw{0xFF}).data, Raw{0xFB});
  Raw request = bytes(10, 2) + bytes(0, 2) + Raw{0, 0x13} + bytes(0x2000, 2) + Raw{0x40, 0x00, 0x10, 0} + bytes(0, 4);
  request.resize(128);
  bus.write(kStation, 0x1000, request);
  const Answer a = bus.logical(10, 0x9000000, Raw{0x00});
  EXPECT_EQ(a.wkc, 1);
  EXPECT_EQ(a.data, Raw{0x04});
}

TEST_F(Registers, an_fmmu_of_bits_may_lie_across_bytes_on_both_sides) {
  // 12 bits from bit 6 of 1200h to bit 3 of logical 20h, against a plain loop over bits.
  bus.write(kStation, 0x0600, bytes(0x20, 4) + bytes(2, 2) + Raw{3, 6} + bytes(0x1200, 2) + Raw{6, 3, 1, 0, 0, 0});
  const std::uint32_t memory = 0x00B5C7E1u, frame = 0x0000A35Cu;
  bus.write(kStation, 0x1200, memory, 4);
  std::uint32_t expected_memory = memory, expected_frame = frame;
  for (unsigned n = 0; n < 12; ++n) {
    const std::uint32_t theirs = frame >> (3 + n) & 1, ours = memory >> (6 + n) & 1;
    expected_memory = (expected_memory & ~(1u << (6 + n))) | theirs << (6 + n);
    expected_frame = (expected_frame & ~(1u << (3 + n))) | ours << (3 + n);
  }
  EXPECT_EQ(value(bus.logical(10, 0x20, bytes(frame, 2)).data), expected_frame);
  EXPECT_EQ(bus.logical(11, 0x20, bytes(frame, 2)).wkc, 1);
  EXPECT_EQ(reg(0x1200, 4), expected_memory);
}

// --- States

TEST_F(Registers, a_state_change_takes_time_and_the_last_request_counts) {
  bus.mailboxes(kStation);
  bus.write(kStation, 0x0120, 2, 2);
  EXPECT_EQ(bus.state(kStation), 1);
  bus.wait(microseconds(400));
  EXPECT_EQ(bus.state(kStation), 1);
  bus.write(kStation, 0x0120, 1, 2);  // changed its mind
  bus.wait(milliseconds(2));
  EXPECT_EQ(bus.state(kStation), 1);
  bus.write(kStation, 0x0120, 2, 2);
  bus.wait(microseconds(500));
  EXPECT_EQ(bus.state(kStation), 2);
}

TEST_F(Registers, the_identification_is_told_on_request) {
  bus.write(kSecond, 0x0120, 0x21, 2);
  EXPECT_EQ(bus.state(kSecond), 0x21);
  EXPECT_EQ(bus.status_code(kSecond), 101);
  bus.write(kSecond, 0x0120, 0x01, 2);
  EXPECT_EQ(bus.state(kSecond), 0x01);
  EXPECT_EQ(bus.status_code(kSecond), 0);
}

TEST_F(Registers, clearing_the_sync_managers_right_behind_a_request_for_init_is_no_error) {
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  bus.write(kStation, 0x0120, 0x11, 2);
  bus.write(kStation, 0x0800, Raw(64));
  bus.wait(milliseconds(1));
  EXPECT_EQ(bus.state(kStation), 1);
  EXPECT_EQ(bus.status_code(kStation), 0);
}

TEST_F(Registers, areas_over_each_other_are_an_error_of_the_sync_managers) {
  bus.mailboxes(kStation);
  ASSERT_EQ(bus.request(kStation, 2), 2);
  bus.sync_manager(kStation, 2, 0x1100, 6, 0x64);
  bus.sync_manager(kStation, 3, 0x1400, 6, 0x20);
  bus.sync_manager(kStation, 4, 0x1800, 6, 0x20);  // one that the station does not have
  EXPECT_EQ(bus.request(kStation, 4), 0x12);
  EXPECT_EQ(bus.status_code(kStation), 0x17);
  bus.sync_manager(kStation, 4, 0, 0, 0, false);
  EXPECT_EQ(bus.request(kStation, 0x14), 4);
}

}  // namespace
}  // namespace gantry::sim::test
