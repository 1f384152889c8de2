// The virtual stations' mailbox: requests of any content, each reply read. Input: first byte the kind of station (bits
// 0-1), the state to which it is brought (bits 2-3), and whether the CoE server stands alone (bit 4), where a read past
// the end of a request leaves its heap block; then requests: flags, length, bytes. Flags: bit 0: the header is put
// right (length, CoE, counter); bits 1-3: how many replies are read; bits 4-5: what the bytes are - a mailbox, a state
// to ask for, a request to repeat the last reply, a piece of a mailbox; bit 6: with the counter of the request before;
// bits 4, 5 and 7: a mailbox, and before it the station loses its power.
#include <memory>

#include "sim/objects/coe_server.hpp"
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;
using fuzz::SegmentBench;

namespace {

constexpr unsigned kOut = 0x1000, kIn = 0x1080;
constexpr std::size_t kMostBytes = 128;
constexpr int kMostRequests = 20;
constexpr std::uint16_t kShort = 40;  ///< a mailbox for which many replies need several

/// Profiles that differ in what is stored and when, in axes, in whether PDOs can be mapped, and in their mailbox.
struct Kind {
  SegmentBench line;
  std::size_t bytes;  ///< of each mailbox
};
Kind& station(unsigned kind) {
  static Kind stations[] = {{{{"drives/id286.yaml"}}, kMostBytes},
                            {{{"drives/amd530b.yaml"}}, kMostBytes},
                            {{{"drives/std402ec.yaml"}, kShort}, kShort},
                            {{{"devices/aio4.yaml"}, kShort}, kShort}};
  return stations[kind % std::size(stations)];
}

/// Length, CoE and counter of a request of `size` bytes.
void put_right(std::span<std::byte> mailbox, std::size_t size, unsigned counter) {
  using namespace devices::wire;
  const std::size_t length = size < kMailboxHeader ? 0 : size - kMailboxHeader;
  put_le<std::uint16_t>(mailbox, 0, static_cast<std::uint16_t>(length));
  mailbox[5] = static_cast<std::byte>(3 | (counter % 7 + 1) << 4);
}

/// A reply is a mailbox: its length lies inside it. False: there was none.
bool read_reply(SegmentBench& line, std::size_t size) {
  std::array<std::byte, kMostBytes> reply{};
  if (!line.read(0, kIn, std::span(reply).first(size))) return false;
  const unsigned length = devices::wire::get_le<std::uint16_t>(reply, 0);
  if (length + devices::wire::kMailboxHeader > size) std::abort();
  return true;
}

void ask_state(SegmentBench& line, unsigned state) {
  if (line.segment.station(0).state() == devices::wire::AlState::PreOp) line.lay_out(0);
  line.write_outputs(0);
  line.poke(0, 0x0120, state, 0);
  line.wait(microseconds(200));
}

void run_alone(fuzz::Input& in, sim::ObjectDictionary& objects, std::size_t size, bool pre_op) {
  sim::CoeServer server(objects, size);
  unsigned counter = 0;
  for (int requests = 0; requests < kMostRequests && !in.empty(); ++requests) {
    const unsigned flags = in.u8();
    const auto bytes = in.take(in.u8() % size);
    std::vector<std::byte> mailbox(bytes.begin(), bytes.end());
    if ((flags & 1) != 0 && mailbox.size() >= devices::wire::kMailboxHeader)
      put_right(mailbox, mailbox.size(), ++counter);
    server.take(mailbox, pre_op);
    while (server.waiting()) {
      const auto reply = server.next();
      if (reply.size() > size) std::abort();
      fuzz::note_said(reply);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using State = devices::wire::AlState;
  constexpr State kStates[] = {State::PreOp, State::PreOp, State::SafeOp, State::Op};
  fuzz::Input in(data, size);
  const unsigned how = in.u8();
  auto& [line, size_of_mailbox] = station(how);
  line.renew();
  const State state = kStates[how >> 2 & 3];
  if ((how & 0x10) != 0) {
    run_alone(in, line.segment.station(0).objects(), size_of_mailbox, state == State::PreOp);
    return 0;
  }
  line.bring_up(state);
  unsigned counter = 0;
  bool repeat = false;
  for (int requests = 0; requests < kMostRequests && !in.empty(); ++requests) {
    const unsigned flags = in.u8();
    const auto bytes = in.take(in.u8() % size_of_mailbox);
    const std::unique_ptr<std::byte[]> block(new std::byte[size_of_mailbox]());  // of the exact size
    const std::span mailbox(block.get(), size_of_mailbox);
    const bool power = (flags & 0xB0) == 0xB0;
    if (power) {
      line.segment.power_off(StationId{0});
      line.segment.power_on(StationId{0});
      line.bring_up(State::PreOp);
      repeat = false;
    }
    std::copy(bytes.begin(), bytes.end(), mailbox.begin());
    switch (power ? 0 : flags >> 4 & 3) {
      case 0:
        if ((flags & 1) != 0) {
          if ((flags & 0x40) == 0) ++counter;
          put_right(mailbox, bytes.size(), counter);
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
    for (unsigned reads = 0; reads <= (flags >> 1 & 7) && read_reply(line, size_of_mailbox); ++reads) {
    }
  }
  return 0;
}
