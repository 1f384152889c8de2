#include "devices/rt/canopen_cyclic.hpp"

#include <deque>
#include <gtest/gtest.h>
#include <vector>

namespace gantry::devices {
namespace {

struct FakeCan final : CanPort {
  std::vector<CanFrame> sent;
  std::deque<CanFrame> waiting;
  bool works = true;
  bool send(const CanFrame& frame) noexcept override {
    if (works) sent.push_back(frame);
    return works;
  }
  bool receive(CanFrame& frame, Time) noexcept override {
    if (waiting.empty()) return false;
    frame = waiting.front();
    waiting.pop_front();
    return true;
  }
};

TEST(CanopenCyclic, sends_sync_each_tick_and_drains_what_came) {
  FakeCan port;
  CanopenCyclic can;
  for (int i = 0; i < 20; ++i) port.waiting.push_back({.id = 0x701, .size = 1});
  EXPECT_EQ(can.tick(port, Time{}).received, CanopenCyclic::kFramesPerTick);
  EXPECT_EQ(can.tick(port, Time{}).received, 4);
  ASSERT_EQ(port.sent.size(), 2u);
  EXPECT_EQ(port.sent[0].id, 0x80u);
  EXPECT_EQ(port.sent[0].size, 0);
}

TEST(CanopenCyclic, a_bus_that_takes_nothing_is_told_after_50_ms) {
  FakeCan port;
  port.works = false;
  CanopenCyclic can;
  int ticks = 1;
  while (can.tick(port, Time{}).fault == Fault::None && ticks < 1000) ++ticks;
  EXPECT_EQ(ticks, CanopenCyclic::kSendFailuresMax);
}

}  // namespace
}  // namespace gantry::devices
