#include "sim/segment/foreign_frame.hpp"

#include <algorithm>
#include <array>

#include "devices/wire/ethercat.hpp"

namespace gantry::sim {

std::span<const std::byte> foreign_frame() noexcept {
  using namespace devices::wire;
  static const auto frame = [] {
    std::array<std::byte, kMinEthernetFrame> f{};
    std::fill_n(f.begin(), 6, std::byte{0xFF});
    constexpr std::array kSender{0x02, 0x1B, 0x21, 0x0A, 0x0B, 0x0C};  // a card's address after the stations
    for (std::size_t i = 0; i < kSender.size(); ++i) f[6 + i] = static_cast<std::byte>(kSender[i]);
    f[12] = static_cast<std::byte>(kEtherType >> 8), f[13] = static_cast<std::byte>(kEtherType & 0xFF);
    constexpr std::uint16_t kData = 2, kStations = 6;
    put_le<std::uint16_t>(
        f, kEthernetHeader,
        static_cast<std::uint16_t>((kDatagramHeader + kData + kWorkingCounter) | kTypeDatagrams << 12));
    put_datagram_header(std::span(f).subspan(kFrameHeader),
                        {.command = Command::Brd, .index = 1, .address = 0x0130'0006, .length = kData});
    put_le<std::uint16_t>(f, kFrameHeader + kDatagramHeader + kData, kStations);
    return f;
  }();
  return frame;
}

}  // namespace gantry::sim
