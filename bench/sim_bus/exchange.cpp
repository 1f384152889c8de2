// What a cycle of the reference machine costs in process: the segment alone (SYNC0 of every station, then the frame),
// and with the master around it. Drives stand, or move in CSP.
//   build/release/bin/bench_sim_bus          (in the source folder: it reads the shipped machine)
#include <array>
#include <benchmark/benchmark.h>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <vector>

#include "config/machine.hpp"
#include "devices/ethercat/master.hpp"
#include "devices/passing_port.hpp"
#include "devices/rt/drive.hpp"
#include "devices/wire/bytes.hpp"
#include "sim/segment/segment.hpp"
#include "sim/segment/segment_port.hpp"

namespace gantry::sim {
namespace {

/// Keeps the last frame as it was sent.
class Tap final : public devices::PassingPort {
 public:
  explicit Tap(devices::FramePort& port) : PassingPort(port) {}
  bool send(devices::PortIndex port, std::span<const std::byte> frame) noexcept override {
    last.assign(frame.begin(), frame.end());
    return port_.send(port, frame);
  }
  std::vector<std::byte> last;
};

config::Machine reference() { return config::load_machine("config/machines/dispenser.yaml").value(); }

/// Drives of the three makes in turn, until there are so many axes.
config::Machine line_of(std::int64_t axes) {
  config::Machine m;
  m.bus = reference().bus;
  constexpr std::array kMakes{"id286", "amd530b", "std402ec"};
  for (std::size_t i = 0; axes > 0; ++i) {
    config::Station s;
    s.id = StationId{static_cast<std::uint16_t>(i)};
    s.position = static_cast<int>(i);
    s.name = "s" + std::to_string(i);
    const std::string make = axes == 1 ? kMakes[0] : kMakes[i % kMakes.size()];
    s.profile = config::load_profile("config/drives/" + make + ".yaml").value();
    axes -= make == "std402ec" ? 2 : 1;
    m.stations.push_back(std::move(s));
  }
  return m;
}

/// A machine in OP, cycles at 1 kHz.
struct Bench {
  config::Machine machine;
  VirtualClock clock;
  Segment segment{machine, clock};
  SegmentPort port{segment, clock};
  Tap tap{port};
  devices::EthercatMaster master{machine, tap, clock};
  Time next{};
  devices::Exchange last;
  struct Place {
    std::span<std::byte> outputs;
    std::size_t at;
  };
  std::vector<Place> controls, targets;

  explicit Bench(config::Machine m = reference()) : machine(std::move(m)) {
    if (auto ok = master.bring_up(); !ok) throw std::runtime_error(to_text(ok.error()));
    next = master.first_cycle(clock.now() + milliseconds(1));
    for (int i = 0; i < 20; ++i) cycle();
    if (auto ok = master.request_operation(); !ok) throw std::runtime_error(to_text(ok.error()));
    for (int i = 0; i < 500; ++i) cycle();
    if (last.ethercat.al_states != 8) throw std::runtime_error("not every station is in OP");
  }
  void cycle() {
    clock.sleep_until(next);
    last = master.exchange(next + microseconds(300));
    next += milliseconds(1);
  }
  /// Controlword and target of every axis.
  void command(std::uint16_t control, std::int32_t target) {
    for (const Place& p : controls) devices::wire::put_le<std::uint16_t>(p.outputs, p.at, control);
    for (const Place& p : targets) devices::wire::put_le<std::int32_t>(p.outputs, p.at, target);
  }
  /// Where the profiles map what is commanded. The mode is CSP throughout.
  void find_places() {
    for (const auto& s : machine.stations) {
      if (s.bus != config::BusKind::EtherCat || !s.profile.drive) continue;
      const auto out = master.outputs(s.id);
      std::size_t at = 0;
      for (const auto& pdo : s.profile.rx_pdos)
        for (const auto& e : pdo.entries) {
          const auto object = e.address.index & 0x67FF;
          if (object == 0x6040) controls.push_back({out, at});
          if (object == 0x607A) targets.push_back({out, at});
          if (object == 0x6060) devices::wire::put_le<std::int8_t>(out, at, 8);
          at += e.bit_length / 8u;
        }
    }
  }
  void enable() {
    find_places();
    for (const int control : {0x00, 0x06, 0x07, 0x0F})
      for (int i = 0; i < 5; ++i) command(static_cast<std::uint16_t>(control), 0), cycle();
  }
};

void segment_alone_standing(benchmark::State& state) {
  Bench b;
  std::vector<std::byte> frame;
  for (auto _ : state) {
    b.clock.sleep_until(b.next);
    frame = b.tap.last;
    benchmark::DoNotOptimize(b.segment.process(frame));
    b.next += milliseconds(1);
  }
}
BENCHMARK(segment_alone_standing);

void master_and_segment(benchmark::State& state) {
  Bench b;
  b.enable();
  std::int64_t cycle = 0;
  for (auto _ : state) {
    if (state.range(0) != 0) {
      b.command(0x0F, static_cast<std::int32_t>(std::lround(2000 * std::sin(1e-3 * static_cast<double>(++cycle)))));
    }
    b.cycle();
  }
  if (!b.last.inputs_fresh) state.SkipWithError("an exchange was lost");
}
BENCHMARK(master_and_segment)->ArgName("moving")->Arg(0)->Arg(1);

void a_line_of_drives(benchmark::State& state) {
  Bench b(line_of(state.range(0)));
  b.enable();
  for (auto _ : state) b.cycle();
  if (!b.last.inputs_fresh) state.SkipWithError("an exchange was lost");
}
BENCHMARK(a_line_of_drives)->ArgName("axes")->Arg(1)->Arg(4)->Arg(16)->Arg(64);

}  // namespace
}  // namespace gantry::sim
