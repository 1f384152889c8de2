// The 1 ms loop of the reference machine on a virtual bus that others than the loop can send on: a tap stands between,
// as a network card would, and its second way out is a socket whose other end the test reads.
//   LoopBench b;  b.operate();  b.enable();  b.home();  b.play(segments);  b.ticks(100);
#pragma once
#include <atomic>
#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "app/cycle/loop.hpp"
#include "app/cycle/pacer.hpp"
#include "app/cycle/stop_frame.hpp"
#include "app/cycle/watchdog.hpp"
#include "app/run/compose.hpp"
#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/passing_port.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"
#include "tests/app/cycle/two_ends.hpp"
#include "tests/app/cycle/wire_judge.hpp"

namespace gantry::test {

inline const config::Machine& reference_machine() {
  static const config::Machine machine = [] {
    auto m = config::load_machine(GANTRY_SOURCE_DIR "/config/machines/dispenser.yaml");
    EXPECT_TRUE(m) << (m ? "" : to_text(m.error().front()));
    return m ? std::move(*m) : config::Machine{};
  }();
  return machine;
}

/// Keeps what the loop sends; can hold it up in its exchange.
class TapPort final : public devices::PassingPort {
 public:
  TapPort(devices::FramePort& port, int socket) : PassingPort(port), socket_(socket) {}
  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override {
    size_ = std::min(frame.size(), last_.size());
    std::copy_n(frame.begin(), size_, last_.begin());
    if (const auto image = decode_cyclic(frame)) {
      enabling_ = enabling_ || (stop_ ? image->goes_on_after(*stop_) : image->any_enabling());
      open_ = open_ || image->valve();
    }
    sent_.fetch_add(1);
    return port_.send(port, frame);
  }
  devices::Received receive(std::span<std::byte> buffer, Time deadline) noexcept override {
    while (hold_up.load()) ::usleep(100);
    return port_.receive(buffer, deadline);
  }
  [[nodiscard]] int descriptor() const noexcept override { return socket_; }

  [[nodiscard]] std::vector<std::byte> last() const {
    return {last_.begin(), last_.begin() + static_cast<std::ptrdiff_t>(size_)};
  }
  [[nodiscard]] WireImage last_image() const { return decode_cyclic(last()).value_or(WireImage{}); }
  [[nodiscard]] int sent() const { return sent_.load(); }
  /// From here on enabled() and opened() tell what the loop has asked for since; after a stop, what goes on after it.
  void forget(std::optional<WireImage> stop = {}) { enabling_ = open_ = false, stop_ = stop; }
  [[nodiscard]] bool enabled() const { return enabling_; }
  [[nodiscard]] bool opened() const { return open_; }

  std::atomic<bool> hold_up{false};

 private:
  int socket_;
  std::array<std::byte, devices::kMaxFrameBytes> last_{};
  std::size_t size_ = 0;
  bool enabling_ = false, open_ = false;
  std::optional<WireImage> stop_;
  std::atomic<int> sent_{0};
};

/// A clock on which something happens when it is read the n-th time from now, and whose sleep can last too long.
class MeddledClock final : public Clock {
 public:
  [[nodiscard]] Time now() const noexcept override {
    if (countdown_ > 0 && --countdown_ == 0) what_();
    return clock_.now() - stood_still_;
  }
  void sleep_until(Time t) noexcept override { clock_.sleep_until(t + stood_still_ + std::exchange(too_long_, {})); }
  bool stand_still(Time stall) noexcept override {
    if (patient) stood_still_ += stall;
    return patient;
  }
  void oversleep(Time by) { too_long_ = by; }
  bool patient = false;  ///< as of a machine simulated in this process
  [[nodiscard]] bool is_virtual() const noexcept override { return true; }
  void meddle(int readings, std::function<void()> what) { countdown_ = readings, what_ = std::move(what); }

 private:
  VirtualClock clock_;
  Time stood_still_{}, too_long_{};
  mutable int countdown_ = 0;
  std::function<void()> what_;
};

struct LoopBench {
  /// `hardware`: stops at stalls that only a simulated machine tolerates.
  explicit LoopBench(config::Machine m = reference_machine(), bool hardware = true)
      : machine(std::move(m)),
        setup(run::compose_loop(machine, hardware ? run::Host::Hardware : run::Host::VirtualTime).value()) {
    EXPECT_TRUE(run::compose_startup(machine));
    master = std::make_unique<devices::EthercatMaster>(machine, tap, clock);
    loop = std::make_unique<cycle::Loop>(setup, *master, nullptr, clock, *channels, &stop);
  }

  void tick(std::int64_t after = 1) {
    if (!pacer) pacer.emplace(master->first_cycle(clock.now() + milliseconds(5)), machine.bus.cycle);
    if (after > 1) clock.sleep_until(clock.now() + (after - 1) * machine.bus.cycle);
    pacer->shift(loop->tick(pacer->wait(clock)));
    for (cycle::Snapshot s; channels->snapshots.pop(s);) {
      if (!s.sent) skipped.push_back(s);
      now = s;
    }
    for (cycle::Event e; channels->events.pop(e);) events.push_back(e);
  }
  void ticks(int n) {
    for (int i = 0; i < n; ++i) tick();
  }
  template <class Condition>
  bool until(Condition condition, int limit) {
    for (int i = 0; i < limit; ++i) {
      if (condition()) return true;
      tick();
    }
    return condition();
  }
  /// Sends it and waits for its answer.
  Fault command(cycle::Command c, int limit = 20'000) {
    c.id = ++last_id;
    EXPECT_TRUE(channels->commands.push(c));
    const cycle::Event* answer = nullptr;
    until(
        [&] {
          for (const cycle::Event& e : events)
            if (e.kind == cycle::EventKind::CommandDone && e.id == c.id) answer = &e;
          return answer != nullptr;
        },
        limit);
    EXPECT_NE(answer, nullptr) << "no answer to command " << int(c.kind);
    return answer != nullptr ? answer->fault : Fault::Internal;
  }
  [[nodiscard]] int told(Fault fault) const {
    return static_cast<int>(std::count_if(events.begin(), events.end(), [&](const cycle::Event& e) {
      return e.kind == cycle::EventKind::Fault && e.fault == fault;
    }));
  }

  void operate() {
    const auto up = master->bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
    // As on a machine that is ready to work.
    std::uint16_t levels = 0;
    for (const auto input : {config::Input::Stop, config::Input::DoorClosed, config::Input::AirOk,
                             config::Input::SafetyOk, config::Input::Mode, config::Input::ClampClosed})
      levels = static_cast<std::uint16_t>(levels | 1u << machine.inputs[static_cast<std::size_t>(input)]->bit);
    io = machine.inputs[static_cast<std::size_t>(config::Input::DoorClosed)]->station;
    segment.set_io_inputs(io, levels);
    ticks(20);
    ASSERT_TRUE(master->request_operation());
    ASSERT_TRUE(until([&] { return now.state == cycle::State::Disabled; }, 3000));
    ticks(500);  // the clocks come together
  }
  void enable() { ASSERT_EQ(command({.kind = cycle::CommandKind::Enable}), Fault::None); }
  void home() {
    for (const std::uint32_t axes : {1u << machine.z.value, 0x1Fu & ~(1u << machine.z.value)})
      ASSERT_EQ(command({.kind = cycle::CommandKind::Home, .axes = axes}), Fault::None);
  }
  void play(std::vector<motion::Segment> segments) {
    for (motion::Segment& s : segments) {
      s.block = 1;
      s.ends_block = &s == &segments.back();
      ASSERT_TRUE(channels->segments.push(s));
    }
    ASSERT_EQ(command({.kind = cycle::CommandKind::StartBlock, .block = 1}), Fault::None);
  }

  config::Machine machine;
  MeddledClock clock;
  sim::Segment segment{machine, clock};
  sim::SegmentPort port{segment, clock};
  TwoEnds wire;
  TapPort tap{port, wire.in()};
  cycle::LoopSetup setup;
  cycle::StopFrame stop{setup, tap.descriptor()};
  std::unique_ptr<devices::EthercatMaster> master;
  std::unique_ptr<cycle::Channels> channels = std::make_unique<cycle::Channels>();
  std::unique_ptr<cycle::Loop> loop;
  std::optional<cycle::Pacer> pacer;
  StationId io;
  cycle::Snapshot now;
  std::vector<cycle::Snapshot> skipped;  ///< of the cycles that a stall has skipped
  std::vector<cycle::Event> events;
  std::uint32_t last_id = 0;
};

}  // namespace gantry::test
