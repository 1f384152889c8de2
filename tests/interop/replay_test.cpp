// Recorded bring-ups as tests of the parsers of both sides (captures/README.md tells how they were made).
#include <algorithm>
#include <gtest/gtest.h>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/rt/frame.hpp"
#include "sim/segment/segment.hpp"
#include "tests/interop/capture.hpp"
#include "tests/interop/replay_line.hpp"
#include "tests/interop/strange_kinds.hpp"

namespace gantry::interop {
namespace {

constexpr std::uint32_t kMailboxInStatus = 0x080D, kMailboxIn = 0x1080;  // SyncManager 1, as the strange master sets it

TEST(Replay, our_frames_are_built_again_byte_by_byte_and_the_recorded_replies_are_taken) {
  const auto turns = exchanges(read_pcapng("our_master_and_strange_stations.pcapng"));
  ASSERT_GT(turns.size(), 200u);
  std::size_t several = 0;
  for (const auto& [request, reply] : turns) {
    const auto parts = datagrams(request.frame);
    ASSERT_FALSE(parts.empty());
    several += parts.size() > 1;
    std::uint32_t sequence = parts[0].header.index;  // these captures are shorter than 65536 frames
    if (parts.size() > 1) sequence |= static_cast<std::uint32_t>(parts[1].header.index) << 8;
    devices::Frame sent;
    devices::SourceAddress source{};  // of the process that was recorded
    std::copy_n(request.frame.begin() + 6, source.size(), source.begin());
    sent.set_source(source);
    sent.start(sequence);
    for (const auto& d : parts) ASSERT_NE(sent.add(d.header.command, d.header.address, d.data), devices::kNoSlot);
    const auto again = sent.bytes();
    ASSERT_EQ(again.size(), request.frame.size());
    EXPECT_TRUE(std::equal(again.begin() + 14, again.end(), request.frame.begin() + 14)) << "at " << request.time_ns;
    devices::Reply taken;
    ASSERT_EQ(devices::match(sent, reply.frame, taken), devices::Match::Ours) << "at " << request.time_ns;
    const auto came = datagrams(reply.frame);
    for (std::size_t i = 0; i < parts.size(); ++i) {
      EXPECT_EQ(taken.working_counter(i), came[i].working_counter);
      EXPECT_TRUE(std::equal(came[i].data.begin(), came[i].data.end(), taken.data(i).begin()));
    }
  }
  EXPECT_GT(several, 10u);
}

/// As it was recorded: see captures/README.md.
config::Machine recorded_line() {
  config::Machine m;
  for (const char* kind : {"simple", "big_box", "nervous"})
    m.stations.push_back(strange_station(static_cast<int>(m.stations.size()), kind));
  return m;
}

TEST(Replay, the_master_brings_a_recorded_line_up) {
  const auto turns = exchanges(read_pcapng("our_master_and_strange_stations.pcapng"));
  VirtualClock clock;
  ReplayLine line(turns, clock);
  const config::Machine machine = recorded_line();
  devices::EthercatMaster master(machine, line, clock);
  const auto up = master.bring_up();
  ASSERT_TRUE(up) << to_text(up.error());
  EXPECT_GT(line.answered, 300);
  EXPECT_TRUE(line.unknown.empty()) << line.unknown.size() << " questions were never recorded, the first at "
                                    << std::hex << (line.unknown.empty() ? 0 : line.unknown.front());
  ASSERT_EQ(master.stations().size(), 3u);
  const std::uint32_t products[] = {0x106, 0x101, 0x105};  // as strange_stations.py has them
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(master.stations()[i].sii.vendor, 0x5A5Au);
    EXPECT_EQ(master.stations()[i].sii.product, products[i]);
    EXPECT_EQ(master.stations()[i].sii.serial, 99u);
    EXPECT_EQ(master.stations()[i].parent, static_cast<int>(i) - 1);
  }
  // Objects of the recorded conversation, whatever else was asked in between.
  for (const std::size_t i : {1u, 2u}) {
    const auto product = master.read_object(StationId{static_cast<std::uint16_t>(i)}, {0x1018, 2});
    ASSERT_TRUE(product) << to_text(product.error());
    EXPECT_EQ(wire::get_le<std::uint32_t>(*product, 0), products[i]);
  }
  const auto refused = master.read_object(StationId{2}, {0x1008, 0});  // `nervous` has nothing longer than four bytes
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().fault, Fault::SdoAbort);
  EXPECT_GE(master.stations()[2].mailbox.emergencies.size(), 2u);
}

TEST(Replay, a_recorded_line_in_another_order_than_configured_is_refused) {
  VirtualClock clock;
  ReplayLine line(exchanges(read_pcapng("our_master_and_strange_stations.pcapng")), clock);
  config::Machine machine = recorded_line();
  std::swap(machine.stations[0].profile, machine.stations[1].profile);
  const auto up = devices::EthercatMaster(machine, line, clock).bring_up();
  ASSERT_FALSE(up);
  EXPECT_EQ(up.error().fault, Fault::IdentityMismatch) << to_text(up.error());
}

TEST(Replay, the_virtual_line_answers_a_recorded_stranger_as_it_did) {
  const auto machine = config::load_machine(GANTRY_SOURCE_DIR "/config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  const auto turns = exchanges(read_pcapng("soem_and_virtual_line.pcapng"));
  ASSERT_GT(turns.size(), 200u);
  VirtualClock clock;
  sim::Segment segment(*machine, clock);
  const Time begin = clock.now();
  std::size_t datagrams_seen = 0, differ = 0;
  for (const auto& [request, reply] : turns) {
    clock.sleep_until(begin + Time{static_cast<std::int64_t>(request.time_ns - turns.front().first.time_ns)});
    Bytes frame = request.frame;
    ASSERT_TRUE(segment.process(frame));
    const auto was = datagrams(reply.frame), is = datagrams(frame);
    ASSERT_EQ(was.size(), is.size());
    for (std::size_t i = 0; i < was.size(); ++i) {
      const auto offset = was[i].header.address >> 16;
      const bool is_a_time = offset >= 0x0900 && offset < 0x0940;  // of the host, then and now
      if (is_a_time) continue;
      ++datagrams_seen;
      // A question put at the instant when the answer became ready may go either way; the master asks again.
      const bool same = was[i].header.length == is[i].header.length &&
                        was[i].working_counter == is[i].working_counter &&
                        std::equal(was[i].data.begin(), was[i].data.end(), is[i].data.begin());
      const bool may_be_early = offset == wire::reg::kSiiControl || offset == kMailboxInStatus || offset == kMailboxIn;
      EXPECT_TRUE(same || may_be_early) << std::hex << offset << " at " << request.time_ns;
      differ += !same;
    }
  }
  EXPECT_GT(datagrams_seen, 2000u);
  EXPECT_LT(differ, datagrams_seen / 100);
}

}  // namespace
}  // namespace gantry::interop
