// The master's reader of a station's EEPROM, which holds the input behind its first two bytes. The first one: bit 0:
// reads bring 4 bytes instead of 8; bit 1: each takes a while; bits 2-3: what happens at the place that the second byte
// names - nothing, an error, it stays busy, the station is gone; bits 4-5: what is read through the interface - nothing
// (the image goes to the parser alone), the fixed words, everything, both.
#include "devices/ethercat/sii.hpp"
#include "devices/ethercat/station.hpp"
#include "tests/fuzz/input.hpp"
#include "tests/fuzz/liar_port.hpp"

using namespace gantry;
using namespace gantry::devices;

namespace {

class SiiLiar final : public fuzz::LiarPort {
 public:
  SiiLiar(VirtualClock& clock, std::span<const std::byte> image, unsigned how, unsigned place)
      : LiarPort(clock), image_(image), how_(how), place_(2 * place) {}

  Answer answer(const wire::DatagramHeader& asked, std::span<std::byte> data) override {
    if (++asked_ > kMostAsked) return Answer::TakesNot;
    const auto reg = static_cast<std::size_t>(asked.address >> 16);
    if (asked.command == wire::Command::Fpwr) {
      for (std::size_t i = 0; i < data.size(); ++i)
        if (reg + i >= 0x0504 && reg + i < 0x0508) address_[reg + i - 0x0504] = data[i];
      looks_ = 0;
      return Answer::Takes;
    }
    const std::size_t word = wire::get_le<std::uint32_t>(address_, 0);
    const bool there = word >= place_;
    if (there && (how_ & 12) == 12) return Answer::TakesNot;
    unsigned control = (how_ & 1) != 0 ? 0 : unsigned{wire::kSiiReads8};
    if (((how_ & 2) != 0 && looks_++ % 3 != 2) || (there && (how_ & 12) == 8)) control |= wire::kSiiBusy;
    if (there && (how_ & 12) == 4) control |= wire::kSiiNoAcknowledge;
    for (std::size_t i = 0; i < data.size(); ++i) {
      const std::size_t at = reg + i;
      data[i] = std::byte{0};
      if (at == 0x0502 || at == 0x0503) data[i] = static_cast<std::byte>(control >> (8 * (at - 0x0502)));
      if (at >= 0x0504 && at < 0x0508) data[i] = address_[at - 0x0504];
      if (at < 0x0508 || at >= 0x0510) continue;
      const std::size_t from = 2 * word + at - 0x0508;
      data[i] = from < image_.size() ? image_[from] : std::byte{0xFF};  // erased
    }
    return Answer::Takes;
  }

 private:
  std::span<const std::byte> image_;
  std::array<std::byte, 4> address_{};
  static constexpr int kMostAsked = 100;
  unsigned how_;
  std::size_t place_;
  int asked_ = 0, looks_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  fuzz::Input in(data, size);
  const unsigned how = in.u8(), place = in.u8();
  const auto content = in.rest();
  VirtualClock clock;
  SiiLiar port(clock, content, how, place);
  Link link(port, clock);
  if ((how & 0x10) != 0) (void)read_station_sii(link, 0x1001);
  if ((how & 0x20) != 0) (void)read_sii_image(link, 0x1001);
  // And the parser by itself, on a heap block of the exact size.
  const std::vector<std::byte> image(content.begin(), content.end());
  if (const auto sii = parse_sii(image)) {
    StationRecord station;
    station.sii = *sii;
    plan_from_sii(station);
  }
  return 0;
}
