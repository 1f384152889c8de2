// The virtual line against anybody's frames. Input: first byte the state to which the stations are brought, then
// frames. Each begins with a word: length, and the time that passes before; bit 15 set: the bytes are command, station,
// register address and data of one datagram whose headers are put right, so that they reach what lies behind.
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;

namespace {

/// Positional commands count down, fixed ones up; logical addresses are those of SegmentBench::bring_up().
std::uint32_t address(unsigned command, unsigned station, unsigned ado) {
  using fuzz::SegmentBench;
  if (command >= 10 && command <= 12) return station << 12 | (ado & 0xFFF);
  const bool fixed = (command >= 4 && command <= 6) || command == 14;
  return SegmentBench::address(fixed ? SegmentBench::kFirstAddress + station : 0u - station, ado);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static fuzz::SegmentBench line{"drives/id286.yaml", "devices/dio16.yaml"};
  using State = devices::wire::AlState;
  constexpr State kStates[] = {State::Init, State::PreOp, State::SafeOp, State::Op};
  fuzz::Input in(data, size);
  line.renew();
  if (const State state = kStates[in.u8() % 4]; state != State::Init) line.bring_up(state);
  for (int frames = 0; frames < 24 && !in.empty(); ++frames) {
    const unsigned word = in.u16();
    if (const unsigned gap = word >> 12 & 7; gap > 0) line.wait(microseconds(50) * (1 << gap));
    const std::size_t length = (word & 0x7FF) % 1500;
    if ((word & 0x8000) == 0) {
      line.round(in.take(length));
      continue;
    }
    const unsigned command = in.u8() % 16u, station = in.u8() % 4u, ado = in.u16();
    const auto given = in.take(length);
    std::vector<std::byte> bytes(length);  // zeros behind the end of the input
    std::copy(given.begin(), given.end(), bytes.begin());
    const unsigned counter = line.datagram(command, address(command, station, ado), bytes);
    // No station takes part in what runs over its end. (ASan sees nothing: behind an ESC's memory lies more of the
    // ESC.) What reads and writes may write elsewhere, where 0108h says.
    const bool logical = command >= 10 && command <= 12, both = command == 3 || command == 6 || command == 9;
    if (!logical && !both && ado + length > sim::Esc::kMemoryBytes && counter != 0) std::abort();
  }
  line.wait(milliseconds(3));
  return 0;
}
