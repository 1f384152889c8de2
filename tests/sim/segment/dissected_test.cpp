// What the segment answers, judged by Wireshark's EtherCAT dissectors.
#include <cstdio>
#include <fstream>
#include <gtest/gtest.h>
#include <string>

#include "sim/segment/segment.hpp"
#include "tests/sim/machines.hpp"
#include "tests/sim/raw_master.hpp"

namespace gantry::sim::test {
namespace {

void write_pcap(const std::string& path, const std::vector<Raw>& frames) {
  std::ofstream file(path, std::ios::binary);
  const auto put = [&](const Raw& b) {
    file.write(reinterpret_cast<const char*>(b.data()), static_cast<std::streamsize>(b.size()));
  };
  put(bytes(0xA1B2C3D4, 4) + bytes(2, 2) + bytes(4, 2) + bytes(0, 8) + bytes(65535, 4) + bytes(1, 4));
  std::uint64_t us = 0;
  for (const auto& f : frames) {
    put(bytes(0, 4) + bytes(us % 1'000'000, 4) + bytes(f.size(), 4) + bytes(f.size(), 4) + f);
    ++us;
  }
}

std::vector<std::string> tshark(const std::string& arguments) {
  std::vector<std::string> lines;
  FILE* pipe = popen(("tshark " + arguments + " 2>/dev/null").c_str(), "r");
  if (pipe == nullptr) return lines;
  char line[4096];
  while (std::fgets(line, sizeof line, pipe) != nullptr) lines.emplace_back(line);
  pclose(pipe);
  return lines;
}

TEST(Segment, is_understood_by_wireshark) {
  const config::Machine machine = reference();
  VirtualClock clock;
  Segment segment(machine, clock);
  RawMaster bus(segment, clock);
  std::vector<Raw> frames;
  bus.recorded = &frames;
  const int n = bus.address_all();
  for (int i = 0; i < n - 1; ++i) {
    const auto s = static_cast<std::uint16_t>(0x1001 + i);
    for (std::uint16_t w = 0; w < 0x80; w = static_cast<std::uint16_t>(w + 4)) bus.sii(s, w);
    bus.mailboxes(s);
    ASSERT_EQ(bus.request(s, 2), 2);
    EXPECT_EQ(bus.sdo_read(s, 0x1018, 0), 4u);
    EXPECT_EQ(bus.sdo_write(s, 0x1600, 1, 0, 4), 0x06010003u);                  // an abort
    bus.mailbox(s, bytes(0x2000, 2) + Raw{0x40, 0x08, 0x10, 0} + bytes(0, 4));  // a string
    bus.sdo_write(s, 0x607A, 0, 77, 4);
    bus.mailbox(s, bytes(0x2000, 2) + Raw{0x50, 0x18, 0x10, 0} + bytes(0, 4));  // complete access
    bus.mailbox(s, bytes(0x8000, 2) + Raw{1, 0, 0, 0} + bytes(1, 2));           // SDO information: all objects
    while (bus.fetch(s)) {
    }
    bus.mailbox(s, bytes(0x8000, 2) + Raw{3, 0, 0, 0} + bytes(0x607A, 2));
    bus.mailbox(s, bytes(0x8000, 2) + Raw{5, 0, 0, 0} + bytes(0x6098, 2) + Raw{0, 0x7F});
    const std::size_t size = i == 4 ? 12 : 6;
    bus.sync_manager(s, 2, 0x1100, size, 0x64);
    bus.sync_manager(s, 3, 0x1400, size, 0x20);
    bus.fmmu(s, 0, static_cast<std::uint32_t>(16 * i), size, 0x1100, 2);
    bus.fmmu(s, 1, static_cast<std::uint32_t>(16 * i), size, 0x1400, 1);
    ASSERT_EQ(bus.request(s, 4), 4);
    bus.write(s, 0x0120, 8, 2);
  }
  for (int i = 0; i < 20; ++i) {
    bus.wait(milliseconds(1));
    Raw f = RawMaster::frame(RawMaster::datagram(12, 0, 0, Raw(80), true) +
                             RawMaster::datagram(14, 0x1001, 0x0910, Raw(8), true) +
                             RawMaster::datagram(7, 0, 0x0130, Raw(2)));
    bus.process(f);
  }
  segment.drive_fault(AxisId{0}, 0, 0x000A);
  bus.wait(milliseconds(2));
  EXPECT_TRUE(bus.fetch(0x1001));  // the emergency

  const std::string path = ::testing::TempDir() + "gantry_segment_test.pcap";
  write_pcap(path, frames);
  const auto all = tshark("-r " + path + " -Y ecat -T fields -e frame.number");
  EXPECT_EQ(all.size(), frames.size());
  EXPECT_EQ(
      tshark(
          "-r " + path +
          " -Y \"_ws.malformed || _ws.expert.severity == error || ecat_mailbox.invalid || ecat_mailbox.coe.invalid\"")
          .size(),
      0u);
  EXPECT_GE(tshark("-r " + path + " -Y ecat_mailbox.coe").size(), 5u * 2 * 4);
  const auto aborts = tshark("-r " + path + " -Y \"ecat_mailbox.coe.abortcode == 0x06010003\"");
  EXPECT_EQ(aborts.size(), 5u);
  std::remove(path.c_str());
}

}  // namespace
}  // namespace gantry::sim::test
