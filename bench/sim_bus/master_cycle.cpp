// What the master's own part of a cycle costs: outputs of 16 axes into the image, the frame built, the reply judged,
// inputs taken and decoded. The port answers with the frame itself, its working counters filled in; no system call.
//   build/release/bin/bench_sim_bus --benchmark_filter=master_alone
#include <benchmark/benchmark.h>
#include <cstring>
#include <memory>
#include <vector>

#include "devices/rt/cyclic.hpp"
#include "devices/rt/drive.hpp"

namespace gantry::devices {
namespace {

constexpr std::uint16_t kOut = 9, kIn = 19;  // as the shipped drives are mapped

/// Comes back at once, with the working counters that a healthy bus gives.
class Echo final : public FramePort {
 public:
  explicit Echo(std::uint16_t stations) : stations_(stations) {}
  bool send(PortIndex, std::span<const std::byte> frame) noexcept override {
    using namespace wire;
    Slot& s = slots_[count_++];
    std::memcpy(s.bytes.data(), frame.data(), frame.size());
    s.size = frame.size();
    s.bytes[6] |= std::byte{kProcessedMacBit};
    for (std::size_t at = kFrameHeader;;) {
      const auto h = get_datagram_header(std::span(s.bytes).subspan(at));
      const std::size_t counter = at + kDatagramHeader + h.length;
      std::uint16_t wkc = 1;
      if (h.command == Command::Lrw) wkc = static_cast<std::uint16_t>(3 * (h.length / (kOut + kIn)));
      if (h.command == Command::Brd) wkc = stations_;
      put_le<std::uint16_t>(s.bytes, counter, wkc);
      if (!h.more) return true;
      at = counter + kWorkingCounter;
    }
  }
  Received receive(std::span<std::byte> buffer, Time) noexcept override {
    if (taken_ == count_) {
      taken_ = count_ = 0;
      return {};
    }
    const Slot& s = slots_[taken_++];
    std::memcpy(buffer.data(), s.bytes.data(), s.size);
    if (taken_ == count_) taken_ = count_ = 0;
    return {s.size, PortIndex::Primary, Time{}};
  }
  [[nodiscard]] bool link_up(PortIndex) const noexcept override { return true; }

 private:
  struct Slot {
    std::array<std::byte, kMaxFrameBytes> bytes;
    std::size_t size = 0;
  };
  std::uint16_t stations_;
  std::array<Slot, 24> slots_;
  std::size_t count_ = 0, taken_ = 0;
};

DriveLayout layout() {
  DriveLayout l;
  l.controlword.offset = 0, l.mode.offset = 2, l.target.offset = 3, l.probe_function.offset = 7;
  l.statusword.offset = 0, l.mode_display.offset = 2, l.position.offset = 3, l.error_code.offset = 7;
  l.probe_status.offset = 9, l.probe_rising.offset = 11, l.digital_inputs.offset = 15;
  return l;
}

void master_alone(benchmark::State& state) {
  const auto axes = static_cast<std::size_t>(state.range(0));
  std::vector<CyclicStation> stations;
  std::vector<Drive> drives;
  for (std::size_t i = 0; i < axes; ++i) {
    stations.push_back({.address = static_cast<std::uint16_t>(0x1001 + i),
                        .logical = static_cast<std::uint32_t>(0x10000 + i * (kOut + kIn)),
                        .region_bytes = kOut + kIn,
                        .input_at = kOut,
                        .output_bytes = kOut,
                        .input_bytes = kIn,
                        .output_offset = static_cast<std::uint32_t>(i * kOut),
                        .input_offset = static_cast<std::uint32_t>(i * kIn),
                        .clock = true,
                        .mailbox_status = 0x080D});
    drives.emplace_back(layout(), AxisScale(1000, false));
  }
  std::vector<std::byte> outputs(axes * kOut), inputs(axes * kIn);
  Echo port(static_cast<std::uint16_t>(axes));
  AcyclicSlot acyclic;
  const auto cyclic = std::make_unique<Cyclic>(
      CyclicLayout{
          .stations = stations, .reference_address = 0x1001, .stations_on_bus = static_cast<std::uint16_t>(axes)},
      outputs, inputs);
  double target = 0;
  Exchange e;
  for (auto _ : state) {
    target += 0.001;
    for (std::size_t i = 0; i < axes; ++i)
      drives[i].write(std::span(outputs).subspan(i * kOut, kOut), {.goal = DriveGoal::Enabled, .target = target});
    e = cyclic->run(port, acyclic, Time{});
    for (std::size_t i = 0; i < axes; ++i)
      drives[i].read(std::span<const std::byte>(inputs).subspan(i * kIn, kIn), cyclic->fresh(i));
    benchmark::DoNotOptimize(e);
  }
  if (!e.inputs_fresh) state.SkipWithError("an exchange was lost");
}
BENCHMARK(master_alone)->ArgName("axes")->Arg(1)->Arg(16)->Arg(64);

}  // namespace
}  // namespace gantry::devices
