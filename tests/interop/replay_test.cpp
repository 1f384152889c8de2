// Recorded bring-ups as tests of the parsers of both sides (captures/README.md tells how they were made).
#include <fstream>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "devices/rt/frame.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/segment/segment.hpp"

namespace gantry::interop {
namespace {

using Bytes = std::vector<std::byte>;
namespace wire = devices::wire;
constexpr std::uint32_t kMailboxInStatus = 0x080D, kMailboxIn = 0x1080;  // SyncManager 1, as the strange master sets it

struct Record {
  std::uint64_t time_ns = 0;
  Bytes frame;
};

/// Enhanced packets of a little-endian pcapng file.
std::vector<Record> read_pcapng(const std::string& name) {
  std::ifstream file(std::string(GANTRY_SOURCE_DIR "/tests/interop/captures/") + name, std::ios::binary);
  const std::vector<char> raw((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const std::span bytes(reinterpret_cast<const std::byte*>(raw.data()), raw.size());
  std::vector<Record> out;
  for (std::size_t at = 0; at + 12 <= bytes.size();) {
    const auto type = wire::get_le<std::uint32_t>(bytes, at), length = wire::get_le<std::uint32_t>(bytes, at + 4);
    if (length < 12 || at + length > bytes.size()) break;
    if (type == 6) {
      const auto size = wire::get_le<std::uint32_t>(bytes, at + 20);
      const std::uint64_t high = wire::get_le<std::uint32_t>(bytes, at + 12);
      const auto frame = bytes.subspan(at + 28, size);
      out.push_back({high << 32 | wire::get_le<std::uint32_t>(bytes, at + 16), {frame.begin(), frame.end()}});
    }
    at += length;
  }
  return out;
}

struct Datagram {
  wire::DatagramHeader header;
  std::span<const std::byte> data;
  std::uint16_t working_counter = 0;
};
std::vector<Datagram> datagrams(std::span<const std::byte> frame) {
  std::vector<Datagram> out;
  for (std::size_t at = wire::kFrameHeader; at + wire::kDatagramHeader <= frame.size();) {
    const auto header = wire::get_datagram_header(frame.subspan(at));
    const std::size_t end = at + wire::kDatagramHeader + header.length;
    if (end + wire::kWorkingCounter > frame.size()) break;
    out.push_back(
        {header, frame.subspan(at + wire::kDatagramHeader, header.length), wire::get_le<std::uint16_t>(frame, end)});
    if (!header.more) break;
    at = end + wire::kWorkingCounter;
  }
  return out;
}

/// Request and reply, paired by order: one is out at a time in these captures. Not by the bit of the source address
/// that stations set, which a stranger's own address may have.
std::vector<std::pair<Record, Record>> exchanges(const std::vector<Record>& records) {
  std::vector<std::pair<Record, Record>> out;
  for (std::size_t i = 0; i + 1 < records.size(); i += 2) {
    const auto asked = datagrams(records[i].frame), told = datagrams(records[i + 1].frame);
    EXPECT_TRUE(!asked.empty() && asked.size() == told.size() && asked[0].header.index == told[0].header.index)
        << "packet " << i + 2 << " is no reply to the one before";
    out.emplace_back(records[i], records[i + 1]);
  }
  return out;
}

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
