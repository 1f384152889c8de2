// The virtual stations' mailbox: requests of any content, each reply read. Input: first byte the kind of station and
// the state to which it is brought, then requests: flags, length, bytes. Flags: bit 0: the header is put right (length,
// CoE, counter); bits 1-3: how many replies are read; bits 4-5: what the bytes are - a mailbox, a state to ask for, a
// request to repeat the last reply, a piece of a mailbox; bit 6: with the counter of the request before.
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;
using fuzz::SegmentBench;

namespace {

constexpr unsigned kOut = 0x1000, kIn = 0x1080;
constexpr std::size_t kBytes = 128;

/// Profiles that differ in what is stored and when, in axes, and in whether PDOs can be mapped.
SegmentBench& station(unsigned kind) {
  static SegmentBench stations[] = {
      {"drives/id286.yaml"}, {"drives/amd530b.yaml"}, {"drives/std402ec.yaml"}, {"devices/aio4.yaml"}};
  return stations[kind % std::size(stations)];
}

/// A reply is a mailbox: its length lies inside it. False: there was none.
bool read_reply(SegmentBench& line) {
  constexpr std::array<std::byte, kBytes> nothing{};
  line.read(0, kIn, nothing);
  if (line.working_counter() == 0) return false;
  const unsigned length = devices::wire::get_le<std::uint16_t>(line.brought(), 0);
  if (length + devices::wire::kMailboxHeader > kBytes) std::abort();
  return true;
}

void ask_state(SegmentBench& line, unsigned state) {
  line.lay_out(0);
  line.write_outputs(0);
  line.poke(0, 0x0120, state, 0);
  line.wait(microseconds(200));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using State = devices::wire::AlState;
  constexpr State kStates[] = {State::PreOp, State::PreOp, State::SafeOp, State::Op};
  fuzz::Input in(data, size);
  const unsigned how = in.u8();
  SegmentBench& line = station(how);
  line.renew();
  line.bring_up(kStates[how >> 2 & 3]);
  unsigned counter = 0;
  bool repeat = false;
  for (int requests = 0; requests < 24 && !in.empty(); ++requests) {
    const unsigned flags = in.u8();
    const auto bytes = in.take(in.u8() % 128);
    std::array<std::byte, kBytes> mailbox{};
    std::copy(bytes.begin(), bytes.end(), mailbox.begin());
    switch (flags >> 4 & 3) {
      case 0:
        if ((flags & 1) != 0) {
          if ((flags & 0x40) == 0) counter = counter % 7 + 1;
          mailbox[0] = static_cast<std::byte>(bytes.size() < 6 ? 0 : bytes.size() - 6), mailbox[1] = std::byte{0};
          mailbox[5] = static_cast<std::byte>(3 | counter << 4);
        }
        line.write(0, kOut, mailbox);
        break;
      case 1: ask_state(line, std::to_integer<unsigned>(mailbox[0])); break;
      case 2:
        repeat = !repeat;
        line.poke(0, 0x080E, repeat ? 3 : 1);
        break;
      default: line.write(0, kOut + std::to_integer<unsigned>(mailbox[0]) % 130, bytes); break;
    }
    for (unsigned reads = 0; reads <= (flags >> 1 & 7) && read_reply(line); ++reads) {
    }
  }
  return 0;
}
