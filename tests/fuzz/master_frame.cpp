// The master's judge of what came in: any bytes against a frame of any shape. What it takes as the answer must lie
// inside the received bytes and have the shape of what was sent. Input: shape, sequence number, then address and length
// of each datagram, then the received frame. Shape: low bits how many datagrams; bit 6: the sequence number goes along;
// bit 7: the frame that was sent comes back, cut or lengthened by the next byte, with the rest of the input laid over
// it as place and value.
#include <cstdlib>
#include <vector>

#include "devices/rt/frame.hpp"
#include "tests/fuzz/input.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

#ifdef GANTRY_PLANTED_BUG
/// The reader that everyone writes first: believes the length in the datagram. It must be found (planted_test.sh).
std::uint16_t trusting_counter(std::span<const std::byte> received) {
  if (received.size() < wire::kFrameHeader + wire::kDatagramHeader) return 0;
  const auto length = wire::get_datagram_header(received.subspan(wire::kFrameHeader)).length;
  const std::size_t at = wire::kFrameHeader + wire::kDatagramHeader + length;
  if (received[12] == std::byte{0x88} && received[13] == std::byte{0xA4} && at + 2 > received.size()) std::abort();
  return wire::get_le<std::uint16_t>(received, at);
}
#endif

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  const std::uint8_t shape = in.u8();
  Frame sent;
  sent.start(in.u8());
  if ((shape & 0x40) != 0) sent.add_sequence();
  for (int i = 0; i <= (shape & 0x3F) % 7; ++i)
    sent.add(static_cast<wire::Command>(1 + i % 14), in.u16(), static_cast<std::size_t>(in.u8()) * 2);
  std::vector<std::byte> received;
  if ((shape & 0x80) != 0) {
    received.assign(sent.bytes().begin(), sent.bytes().end());
    received[6] |= std::byte{wire::kProcessedMacBit};
    const std::size_t change = in.u8();
    received.resize(change < 0x80 ? received.size() - std::min(change, received.size())
                                  : received.size() + change - 0x80);
    received.shrink_to_fit();                   // a heap block of the exact size, so that a read behind it is seen
    while (!in.empty() && !received.empty()) {  // place, value: what the cable or a station made of it
      const std::size_t at = in.u16() % received.size();
      received[at] = static_cast<std::byte>(in.u8());
    }
  } else {
    const auto rest = in.rest();
    received.assign(rest.begin(), rest.end());
  }
  Reply reply;
  const Match verdict = match(sent, received, reply);
  fuzz::note_said(static_cast<std::uint64_t>(verdict));
  if (verdict == Match::Ours || verdict == Match::Unprocessed) {
    for (SlotIndex slot = 0; slot < sent.slots().size(); ++slot) {
      const auto answer = reply.data(slot);
      if (answer.size() != sent.slots()[slot].length) std::abort();
      if (!answer.empty() &&
          (answer.data() < received.data() || answer.data() + answer.size() > received.data() + received.size()))
        std::abort();
      fuzz::note_said(reply.working_counter(slot));
      fuzz::note_said(answer);
    }
  }
#ifdef GANTRY_PLANTED_BUG
  trusting_counter(received);
#endif
  return 0;
}
