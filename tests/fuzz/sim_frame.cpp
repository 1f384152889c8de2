// The virtual line against anybody's frames. Input: first byte how far the stations are brought up, then frames, each
// with its length in front (payload of the Ethernet frame).
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/segment_bench.hpp"

using namespace gantry;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  fuzz::SegmentBench line;
  if ((in.u8() & 1) != 0) line.mailbox_up();
  for (int frames = 0; frames < 64 && !in.empty(); ++frames) line.round(in.take(in.u16() % 1500));
  line.settle();
  return 0;
}
