// The virtual drive's mailbox: requests of any content in PRE_OP, each reply read. Input: flags, then requests with
// their length in front. Flag bit 0 of a request: its header is put right (length, CoE, counter).
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::SegmentBench line;
  line.mailbox_up();
  unsigned counter = 0;
  const std::vector<std::byte> nothing(128);
  for (int requests = 0; requests < 64 && !in.empty(); ++requests) {
    const unsigned flags = in.u8();
    const auto bytes = in.take(in.u8() % 128);
    std::vector<std::byte> mailbox(128);
    std::copy(bytes.begin(), bytes.end(), mailbox.begin());
    if ((flags & 1) != 0) {
      counter = counter % 7 + 1;
      mailbox[0] = static_cast<std::byte>(bytes.size() < 6 ? 0 : bytes.size() - 6), mailbox[1] = std::byte{0};
      mailbox[5] = static_cast<std::byte>(3 | counter << 4);
    }
    line.write(0, 0x1000, mailbox);
    for (unsigned reads = 0; reads < 1 + (flags >> 1 & 7); ++reads) {
      line.clock.sleep_until(line.clock.now() + milliseconds(1));
      line.segment.advance();
      line.datagram(1, 0, 0x1080, nothing);
      // A reply is a mailbox: its length lies inside it.
      const auto got = std::span(line.answer).subspan(14 + 12);
      const unsigned length = std::to_integer<unsigned>(got[0]) | std::to_integer<unsigned>(got[1]) << 8;
      const unsigned wkc = std::to_integer<unsigned>(got[128]);
      if (wkc != 0 && length + 6 > 128) std::abort();
    }
  }
  return 0;
}
