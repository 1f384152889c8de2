// The bring-up over a line that loses frames, breaks for good, or answers nonsense.
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "devices/passing_port.hpp"
#include "tests/devices/ethercat/bus_bench.hpp"

namespace gantry::devices {
namespace {

/// Loses frame number `n` (counted from 1), or all from there on.
class LossyPort final : public PassingPort {
 public:
  LossyPort(FramePort& port, int n, bool for_good) : PassingPort(port), n_(n), for_good_(for_good) {}
  bool send(PortIndex port, std::span<const std::byte> frame) noexcept override {
    ++sent_;
    if (sent_ == n_ || (for_good_ && sent_ > n_)) return true;
    return port_.send(port, frame);
  }
  [[nodiscard]] int sent() const { return sent_; }

 private:
  int n_, sent_ = 0;
  bool for_good_;
};

int frames_of_bring_up() {
  BusBench b;
  LossyPort port(b.port, 0, false);
  b.port_used = &port;
  EXPECT_TRUE(b.bring_up());
  return port.sent();
}

TEST(Unplug, any_single_frame_of_the_bring_up_may_be_lost) {
  const int frames = frames_of_bring_up();
  RecordProperty("frames", frames);
  for (int n = 1; n <= frames; ++n) {
    BusBench b;
    LossyPort port(b.port, n, false);
    b.port_used = &port;
    const auto up = b.bring_up();
    EXPECT_TRUE(up) << "frame " << n << ": " << to_text(up.error());
  }
}

TEST(Unplug, unplugging_at_any_frame_of_the_bring_up_ends_in_bounded_time_with_a_named_error) {
  const int frames = frames_of_bring_up();
  for (int n = 1; n <= frames; ++n) {
    BusBench b;
    LossyPort port(b.port, n, true);
    b.port_used = &port;
    const Time begin = b.clock.now();
    const auto up = b.bring_up();
    ASSERT_FALSE(up) << "frame " << n;
    EXPECT_EQ(up.error().fault, Fault::BusDown) << "frame " << n << ": " << to_text(up.error());
    EXPECT_LT(b.clock.now() - begin, milliseconds(3000)) << "frame " << n;
  }
}

/// Flips bits in what comes back, behind the headers: what a station with broken firmware would say.
class LyingPort final : public PassingPort {
 public:
  LyingPort(FramePort& port, unsigned seed, double rate) : PassingPort(port), random_(seed), lie_(rate) {}
  Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    const Received got = port_.receive(buffer, deadline);
    const std::size_t data = wire::kFrameHeader + wire::kDatagramHeader;
    if (got.size > data && lie_(random_))
      for (unsigned n = 1 + static_cast<unsigned>(random_()) % 4; n > 0; --n)
        buffer[data + random_() % (got.size - data)] ^= static_cast<std::byte>(1u << (random_() % 8));
    return got;
  }

 private:
  std::mt19937 random_;
  std::bernoulli_distribution lie_;
};

TEST(Unplug, stations_that_answer_nonsense_give_a_named_error_in_bounded_time) {
  constexpr double kRates[] = {0.002, 0.01, 0.05};
  std::map<std::string_view, int> endings;
  for (unsigned seed = 1; seed <= 500; ++seed) {
    BusBench b;
    LyingPort port(b.port, seed, kRates[seed % 3]);
    b.port_used = &port;
    const Time begin = b.clock.now();
    const auto up = b.bring_up();
    ++endings[up ? "up" : info(up.error().fault).name];
    EXPECT_TRUE(up || !up.error().message.empty()) << "seed " << seed;
    EXPECT_LT(b.clock.now() - begin, milliseconds(60'000)) << "seed " << seed;
  }
  for (const auto& [ending, times] : endings) RecordProperty(std::string(ending), times);
  EXPECT_GT(endings.size(), 5u);  // it did meet all sorts
}

}  // namespace
}  // namespace gantry::devices
