// The ring as a stranger sees it: frames made byte by byte (tests/sim/raw_master.hpp), expectations from ETG.1000.4.
#include "sim/segment/segment.hpp"

#include <gtest/gtest.h>
#include <random>

#include "sim/station/station.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

struct Bus : ::testing::Test {
  config::Machine machine = reference();
  VirtualClock clock;
  Segment segment{machine, clock};
  RawMaster bus{segment, clock};
};

TEST_F(Bus, a_broadcast_read_counts_the_stations) {
  const Answer a = bus.send(7, 0, 0x0130, Raw(2));
  EXPECT_EQ(a.wkc, 6);
  EXPECT_EQ(value(a.data), 1u);  // all in INIT
  EXPECT_EQ(bus.last_adp, 6);    // each one adds 1
}

TEST_F(Bus, position_addressing_counts_up_and_only_the_one_that_sees_zero_acts) {
  EXPECT_EQ(bus.send(2, static_cast<std::uint16_t>(-2), 0x0010, bytes(0x1234, 2)).wkc, 1);
  EXPECT_EQ(bus.last_adp, 4);
  EXPECT_EQ(value(bus.send(1, static_cast<std::uint16_t>(-2), 0x0010, Raw(2)).data), 0x1234u);
  EXPECT_EQ(value(bus.send(1, 0, 0x0010, Raw(2)).data), 0u);
  EXPECT_EQ(bus.send(1, static_cast<std::uint16_t>(-6), 0x0010, Raw(2)).wkc, 0);
  EXPECT_EQ(bus.read(0x1234, 0x0010, 2).wkc, 1);
  EXPECT_EQ(bus.read(0x4321, 0x0010, 2).wkc, 0);
}

TEST_F(Bus, read_write_commands_give_the_old_value_and_count_three) {
  bus.address_all();
  EXPECT_EQ(bus.write(0x1001, 0x1200, 0x11223344, 4), 1);
  const Answer fprw = bus.send(6, 0x1001, 0x1200, bytes(0x55667788, 4));
  EXPECT_EQ(fprw.wkc, 3);
  EXPECT_EQ(value(fprw.data), 0x11223344u);
  const Answer aprw = bus.send(3, 0, 0x1200, bytes(1, 4));
  EXPECT_EQ(aprw.wkc, 3);
  EXPECT_EQ(value(aprw.data), 0x55667788u);
  const Answer brw = bus.send(9, 0, 0x1200, bytes(2, 4));
  EXPECT_EQ(brw.wkc, 18);
  EXPECT_EQ(value(brw.data), 3u);  // 2 | 1 from the first station
  EXPECT_EQ(bus.send(8, 0, 0x1200, bytes(9, 4)).wkc, 6);
  EXPECT_EQ(value(bus.read(0x1006, 0x1200, 4).data), 9u);
}

/// A part of a broadcast read that a station refuses was once filled with what earlier frames had left behind.
TEST_F(Bus, a_broadcast_read_brings_nothing_from_under_a_closed_sync_manager) {
  bus.address_all();
  for (std::uint16_t station = 0x1001; station <= 0x1006; ++station)
    bus.sync_manager(station, 0, 0x1000, 16, 0x26);  // a mailbox, closed in INIT
  bus.send(3, 0, 0x1800, Raw(64, 0xFF));             // something to be left behind
  const Answer brd = bus.send(7, 0, 0x0FF0, Raw(64));
  EXPECT_EQ(brd.wkc, 6);  // what lies around the mailbox is read
  EXPECT_EQ(brd.data, Raw(64));
}

TEST_F(Bus, read_multiple_write_spreads_one_stations_value) {
  bus.address_all();
  for (int i = 0; i < 6; ++i)
    bus.write(static_cast<std::uint16_t>(0x1001 + i), 0x1200, 0x10u + static_cast<unsigned>(i), 1);
  EXPECT_EQ(bus.send(14, 0x1003, 0x1200, Raw{0xEE}).wkc, 6);  // FRMW
  EXPECT_EQ(value(bus.read(0x1003, 0x1200, 1).data), 0x12u);
  EXPECT_EQ(value(bus.read(0x1005, 0x1200, 1).data), 0x12u);
  EXPECT_EQ(value(bus.read(0x1001, 0x1200, 1).data), 0xEEu);  // before the one that was read
  EXPECT_EQ(bus.send(13, 0, 0x1200, Raw{0}).wkc, 6);          // ARMW at position 0
  EXPECT_EQ(value(bus.read(0x1006, 0x1200, 1).data), 0xEEu);
}

TEST_F(Bus, several_datagrams_in_a_frame_are_served_in_order) {
  Raw f = RawMaster::frame(RawMaster::datagram(2, 0, 0x0010, bytes(0x1001, 2), true) +
                           RawMaster::datagram(4, 0x1001, 0x0010, Raw(2), true) +
                           RawMaster::datagram(7, 0, 0x0000, Raw(1)));
  ASSERT_TRUE(bus.process(f));
  EXPECT_EQ(value(f, 16 + 12, 2), 1u);
  EXPECT_EQ(value(f, 16 + 14 + 10, 2), 0x1001u);
  EXPECT_EQ(value(f, 16 + 14 + 12, 2), 1u);
  EXPECT_EQ(value(f, 16 + 14 + 14 + 11, 2), 6u);
}

TEST_F(Bus, fmmus_map_as_soon_as_they_are_written_and_count_per_station) {
  bus.address_all();
  bus.fmmu(0x1001, 0, 0x10000, 4, 0x1200, 2);  // written by the bus
  bus.fmmu(0x1001, 1, 0x10000, 4, 0x1300, 1);  // read by the bus, at the same logical address
  bus.fmmu(0x1002, 0, 0x10004, 2, 0x1200, 2);
  bus.fmmu(0x1003, 0, 0x10006, 2, 0x1300, 1);
  bus.write(0x1001, 0x1300, 0xAABBCCDD, 4);
  bus.write(0x1003, 0x1300, 0x5566, 2);
  const Answer lrw = bus.logical(12, 0x10000, Raw{1, 2, 3, 4, 5, 6, 7, 8});
  EXPECT_EQ(lrw.wkc, 3 + 2 + 1);
  EXPECT_EQ(lrw.data, (Raw{0xDD, 0xCC, 0xBB, 0xAA, 5, 6, 0x66, 0x55}));
  EXPECT_EQ(value(bus.read(0x1001, 0x1200, 4).data), 0x04030201u);
  EXPECT_EQ(value(bus.read(0x1002, 0x1200, 2).data), 0x0605u);
  EXPECT_EQ(bus.logical(10, 0x10000, Raw(8)).wkc, 2);
  EXPECT_EQ(bus.logical(11, 0x10000, Raw(8)).wkc, 2);
  EXPECT_EQ(bus.logical(12, 0x20000, Raw(8)).wkc, 0);
  EXPECT_EQ(bus.logical(10, 0x10002, Raw(2)).data, (Raw{0xBB, 0xAA}));  // a part of it
}

TEST_F(Bus, an_fmmu_of_bits_moves_just_those_bits) {
  bus.address_all();
  bus.write(0x1001, 0x1300, 0xFF, 1);
  // Bit 3 of 1300h at bit 5 of logical 10000h.
  bus.write(0x1001, 0x0600, bytes(0x10000, 4) + bytes(1, 2) + Raw{5, 5} + bytes(0x1300, 2) + Raw{3, 1, 1, 0, 0, 0});
  EXPECT_EQ(bus.logical(10, 0x10000, Raw{0x01}).data, Raw{0x21});
  bus.write(0x1001, 0x1300, 0xF7, 1);
  EXPECT_EQ(bus.logical(10, 0x10000, Raw{0xFF}).data, Raw{0xDF});
}

TEST_F(Bus, what_is_no_frame_is_dropped) {
  Raw good = RawMaster::frame(RawMaster::datagram(7, 0, 0, Raw(64)));
  for (std::size_t size = 0; size < good.size(); ++size) {
    Raw cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_FALSE(bus.process(cut)) << size;
  }
  for (const auto& [at, to] : std::vector<std::pair<std::size_t, std::uint8_t>>{
           {12, 0x08}, {15, 0x40}, {14, 0xFF}, {22, 0xFF}, {23, 0x87}, {23, 0x80}}) {
    Raw bad = good;
    bad[at] = to;
    EXPECT_FALSE(bus.process(bad)) << at;
  }
  EXPECT_TRUE(bus.process(good));
}

TEST_F(Bus, a_vlan_tag_is_passed_over) {
  const auto tagged = [](Raw f, const Raw& tag) {
    f.insert(f.begin() + 12, tag.begin(), tag.end());
    return f;
  };
  for (const Raw& tag : {Raw{0x81, 0x00, 0x00, 0x00}, Raw{0x81, 0x00, 0xE0, 0x05}}) {
    Raw f = tagged(RawMaster::frame(RawMaster::datagram(7, 0, 0x0000, Raw(1), true) +
                                    RawMaster::datagram(2, 0, 0x0010, bytes(0x1234, 2))),
                   tag);
    const Raw before = f;
    ASSERT_TRUE(bus.process(f));
    EXPECT_EQ(Raw(f.begin() + 12, f.begin() + 20), Raw(before.begin() + 12, before.begin() + 20));  // tag and headers
    EXPECT_EQ(f[6], before[6] | 0x02);
    EXPECT_EQ(value(f, 31, 2), 6u);  // every station counted
    EXPECT_EQ(value(f, 45, 2), 1u);
    EXPECT_EQ(bus.read(0x1234, 0x0010, 2).wkc, 1);
  }
  // Broken behind its tag it is a frame that the processing unit counts; tagged twice, it is none of ours.
  Raw broken = tagged(RawMaster::frame(RawMaster::datagram(7, 0, 0, Raw(64))), Raw{0x81, 0x00, 0x00, 0x00});
  broken[19] = 0x40;
  EXPECT_FALSE(bus.process(broken));
  EXPECT_EQ(value(bus.read(0x1234, 0x030C, 1).data), 1u);
  Raw twice =
      tagged(tagged(RawMaster::frame(RawMaster::datagram(7, 0, 0, Raw(1))), Raw{0x81, 0, 0, 0}), Raw{0x81, 0, 0, 0});
  EXPECT_FALSE(bus.process(twice));
  EXPECT_EQ(value(bus.read(0x1234, 0x030C, 1).data), 1u);
}

TEST_F(Bus, foreign_frames_pass_when_every_station_lets_them) {
  bus.address_all();
  Raw arp = RawMaster::frame(Raw(40));
  arp[12] = 0x08, arp[13] = 0x06;
  const Raw before = arp;
  EXPECT_FALSE(bus.process(arp));  // 0100h bit 0: destroyed, which is how a station starts
  bus.send(8, 0, 0x0100, Raw{0});
  EXPECT_TRUE(bus.process(arp));
  EXPECT_EQ(arp, before);
  Raw ours = RawMaster::frame(RawMaster::datagram(7, 0, 0, Raw(1)));
  EXPECT_TRUE(bus.process(ours));
  EXPECT_EQ(ours[6], 0x10);  // the source address stays, too
  Raw one = RawMaster::frame(RawMaster::datagram(5, 0x1004, 0x0100, Raw{1}));
  EXPECT_TRUE(bus.process(one));
  EXPECT_FALSE(bus.process(arp));
}

TEST_F(Bus, random_bytes_neither_crash_nor_hang_it) {
  std::mt19937 random(20240501);
  for (int i = 0; i < 100'000; ++i) {
    Raw f = RawMaster::frame(RawMaster::datagram(
        static_cast<std::uint8_t>(random() % 16), static_cast<std::uint16_t>(random() % 3 == 0 ? 0 : random()),
        static_cast<std::uint16_t>(random() % 4 == 0 ? random() : random() % 0x1000),
        Raw(random() % 40, static_cast<std::uint8_t>(random()))));
    if (random() % 4 == 0) f[random() % f.size()] = static_cast<std::uint8_t>(random());
    bus.process(f);
    if (i % 100 == 0) bus.wait(microseconds(random() % 3000));
  }
  SUCCEED() << "seed 20240501";
}

TEST_F(Bus, a_cut_link_hides_what_is_behind_it_and_closes_the_port) {
  segment.cut_link(3);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 3);
  EXPECT_EQ(value(bus.send(1, static_cast<std::uint16_t>(-2), 0x0110, Raw(2)).data),
            0x5613u);  // port 1 closed, no link
  segment.heal_link(3);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
  EXPECT_EQ(value(bus.send(1, static_cast<std::uint16_t>(-2), 0x0110, Raw(2)).data), 0x5A33u);
  EXPECT_EQ(value(bus.send(1, static_cast<std::uint16_t>(-2), 0x0311, Raw(1)).data), 1u);  // lost link, port 1
  segment.cut_link(0);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, -1);
  EXPECT_FALSE(segment.link_up());
}

TEST_F(Bus, a_power_cycle_breaks_the_line_and_returns_a_new_station) {
  bus.address_all();
  segment.power_cycle(StationId{2}, milliseconds(200));
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 2);
  bus.wait(milliseconds(199));
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 2);
  bus.wait(milliseconds(2));
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
  EXPECT_EQ(bus.read(0x1003, 0x0010, 2).wkc, 0);  // its address is gone
  EXPECT_EQ(bus.read(0x1004, 0x0010, 2).wkc, 1);
}

TEST_F(Bus, lost_frames_are_lost_and_the_next_one_is_not) {
  segment.lose_frames(2);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, -1);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, -1);
  EXPECT_EQ(bus.send(7, 0, 0, Raw(1)).wkc, 6);
}

TEST_F(Bus, sii_tells_identity_alias_mailboxes_and_categories) {
  bus.address_all();
  EXPECT_EQ(bus.sii(0x1001, 0x0008), machine.stations[0].profile.identity.vendor);
  EXPECT_EQ(bus.sii(0x1001, 0x000A), machine.stations[0].profile.identity.product);
  EXPECT_EQ(bus.sii(0x1002, 0x0004) & 0xFFFF, 101u);
  EXPECT_EQ(value(bus.read(0x1002, 0x0012, 2).data), 101u);
  EXPECT_EQ(bus.sii(0x1001, 0x0018), 128u << 16 | 0x1000u);
  EXPECT_EQ(bus.sii(0x1001, 0x001A), 128u << 16 | 0x1080u);
  EXPECT_EQ(bus.sii(0x1001, 0x001C) & 0xFFFF, 4u);  // CoE
  EXPECT_EQ(bus.sii(0x1006, 0x001C) & 0xFFFF, 0u);  // the I/O station has no mailbox
  std::vector<unsigned> found;
  std::uint16_t word = 0x0040;
  for (int i = 0; i < 20; ++i) {
    const std::uint32_t header = bus.sii(0x1001, word);
    found.push_back(header & 0xFFFF);
    if (found.back() == 0xFFFF) break;
    word = static_cast<std::uint16_t>(word + 2 + (header >> 16));
  }
  EXPECT_EQ(found, (std::vector<unsigned>{10, 30, 40, 41, 50, 51, 60, 0xFFFF}));
}

TEST_F(Bus, pdos_of_the_sii_name_their_sync_manager_and_types) {
  bus.address_all();
  // The terminal has no mailbox: its outputs are SM0, its inputs SM1; a drive's are SM2 and SM3 (ETG.2010 table 14).
  for (const auto& [station, rx, tx] : {std::tuple{0x1001, 2, 3}, std::tuple{0x1006, 0, 1}}) {
    const auto s = static_cast<std::uint16_t>(station);
    std::uint16_t word = 0x0040;
    for (std::uint32_t header = bus.sii(s, word); (header & 0xFFFF) != 0xFFFF; header = bus.sii(s, word)) {
      const auto at = static_cast<std::uint16_t>(word + 2);
      const unsigned sm = bus.sii(s, static_cast<std::uint16_t>(at + 1)) >> 8 & 0xFF;
      const unsigned type = bus.sii(s, static_cast<std::uint16_t>(at + 6)) & 0xFF;
      if ((header & 0xFFFF) == 51) {
        EXPECT_EQ(sm, static_cast<unsigned>(rx));
      }
      if ((header & 0xFFFF) == 50) {
        EXPECT_EQ(sm, static_cast<unsigned>(tx));
      }
      if ((header & 0xFFFF) == 51) {
        EXPECT_EQ(type, 0x06u);
      }  // UNSIGNED16
      if ((header & 0xFFFF) == 30) {
        EXPECT_EQ(bus.sii(s, static_cast<std::uint16_t>(at + 8)) & 0xFFFF, 0x0011u);
        const unsigned details = bus.sii(s, static_cast<std::uint16_t>(at + 2)) >> 8 & 0xFF;
        EXPECT_EQ(details, station == 0x1001 ? 0x2Fu : 0u);
      }
      if ((header & 0xFFFF) == 60) {
        EXPECT_EQ(bus.sii(s, static_cast<std::uint16_t>(at + 7)) & 0xFFFF, 0x0300u);
      }
      word = static_cast<std::uint16_t>(at + (header >> 16));
    }
  }
}

TEST_F(Bus, the_checksum_of_the_sii_is_that_of_its_polynomial) {
  bus.address_all();
  Raw words;
  for (std::uint16_t w = 0; w < 8; w = static_cast<std::uint16_t>(w + 2)) words = words + bytes(bus.sii(0x1002, w), 4);
  unsigned crc = 0xFF;  // x^8 + x^2 + x + 1, most significant bit first
  for (std::size_t i = 0; i < 14; ++i)
    for (int bit = 7; bit >= 0; --bit) {
      const bool in = (words[i] >> bit & 1) != 0, top = (crc & 0x80) != 0;
      crc = (crc << 1 & 0xFF) ^ (in != top ? 0x07u : 0u);
    }
  EXPECT_EQ(words[14], crc);
}

}  // namespace
}  // namespace gantry::sim::test
