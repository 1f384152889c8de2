#include "devices/ethercat/sii.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::devices {
namespace {

using namespace wire;

constexpr Time kBusyTimeout = milliseconds(100);
constexpr Time kBusyPoll = microseconds(100);
constexpr std::size_t kInterfaceBytes = 14;  // 0502h control, 0504h address, 0508h data
constexpr std::size_t kFixedWords = 0x20;    // identity and mailboxes

/// What a station's interface shows after a read: control word and up to eight bytes.
using Interface = std::array<std::byte, kInterfaceBytes>;

std::uint16_t control(const Interface& i) { return get_le<std::uint16_t>(i, 0); }
std::size_t words_per_read(const Interface& i) { return (control(i) & kSiiReads8) != 0 ? 4 : 2; }

/// Looks at the interfaces of several stations until none is busy.
Result<void> wait_idle(Link& link, std::uint16_t first, std::span<Interface> stations) {
  const Time deadline = link.clock().now() + kBusyTimeout;
  std::vector<Datagram> look(stations.size());
  for (;;) {
    for (std::size_t i = 0; i < stations.size(); ++i)
      look[i] = {Command::Fprd, physical_address(static_cast<std::uint16_t>(first + i), reg::kSiiControl), stations[i]};
    if (auto ok = link.transact(look); !ok) return ok;
    std::string busy;
    for (std::size_t i = 0; i < stations.size(); ++i) {
      if (look[i].working_counter != kWkcRead)
        return fail(Fault::StationMissing, "the station does not answer (SII, 0502h)",
                    fmt::format("station address {:04X}h", first + i));
      if ((control(stations[i]) & kSiiBusy) != 0) busy = fmt::format("station address {:04X}h", first + i);
    }
    if (busy.empty()) return {};
    if (link.clock().now() >= deadline) return fail(Fault::SiiInvalid, "the SII EEPROM stays busy", busy);
    link.pause(kBusyPoll);
  }
}

/// Lets all these stations read from `word` at once. The fewest words that all of them gave.
Result<std::size_t> read_words(Link& link, std::uint16_t first, std::span<Interface> stations, std::uint32_t word) {
  std::array<std::byte, 6> order{};  // control and address in one write
  put_le<std::uint16_t>(order, 0, kSiiRead);
  put_le<std::uint32_t>(order, 2, word);
  if (stations.size() == 1) {
    if (auto ok = link.write(first, reg::kSiiControl, std::span<const std::byte>(order)); !ok)
      return tl::unexpected(ok.error());
  } else if (auto ok = link.write_all(reg::kSiiControl, order); !ok) {
    return tl::unexpected(ok.error());
  }
  if (auto ok = wait_idle(link, first, stations); !ok) return tl::unexpected(ok.error());
  std::size_t words = 4;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    // These two bits are about the first words at start-up, which an empty EEPROM or one that was written without a new
    // checksum fails (an ET1100 sets both until the next reload); reading still works.
    if ((control(stations[i]) & (kSiiErrors & ~(kSiiChecksumError | kSiiNotLoaded))) != 0)
      return fail(
          Fault::SiiInvalid,
          fmt::format("the SII EEPROM reports an error (0502h = {:04X}h) at word {:04X}h", control(stations[i]), word),
          fmt::format("station address {:04X}h", first + i));
    words = std::min(words, words_per_read(stations[i]));
  }
  return words;
}

}  // namespace

Result<std::vector<StationSii>> read_all_sii(Link& link, std::uint16_t first, int count) {
  std::vector<Interface> stations(static_cast<std::size_t>(count));
  std::vector<Bytes> images(stations.size(), Bytes(2 * kFixedWords));
  if (auto ok = wait_idle(link, first, stations); !ok) return tl::unexpected(ok.error());
  for (std::size_t word = 0; word < kFixedWords;) {
    const auto words = read_words(link, first, stations, static_cast<std::uint32_t>(word));
    if (!words) return tl::unexpected(words.error());
    for (std::size_t i = 0; i < stations.size(); ++i)
      std::copy_n(stations[i].begin() + 6, 2 * *words, images[i].begin() + static_cast<std::ptrdiff_t>(2 * word));
    word += *words;
  }
  std::vector<StationSii> found;
  for (const Bytes& image : images) found.push_back(*parse_sii_words(image));
  return found;
}

Result<StationSii> read_station_sii(Link& link, std::uint16_t station) {
  auto all = read_all_sii(link, station, 1);
  if (!all) return tl::unexpected(all.error());
  return std::move(all->front());
}

namespace {

/// An image that grows by what is read. The end moves away as headers are read: first the fixed words, then each
/// category.
struct Growing {
  Bytes image;
  std::size_t end = 2 * std::size_t{sii::kFirstCategory} + 4, next_header = end - 4, most = kMaxSiiBytes;
  bool whole = false;

  void add(std::span<const std::byte> read) {
    if (whole) return;
    image.insert(image.end(), read.begin(), read.end());
    constexpr std::size_t kFixed = 2 * std::size_t{sii::kFirstCategory};
    if (image.size() >= kFixed && most == kMaxSiiBytes)
      most = std::min(kMaxSiiBytes, (std::size_t{get_le<std::uint16_t>(image, 2 * sii::kSize)} + 1) * 128);
    while (image.size() >= next_header + 4 && next_header + 4 == end) {
      if (get_le<std::uint16_t>(image, next_header) == static_cast<std::uint16_t>(sii::Category::End)) {
        whole = true;
        return;
      }
      next_header += 4 + 2 * std::size_t{get_le<std::uint16_t>(image, next_header + 2)};
      end = next_header + 4;
    }
    if (image.size() < end && image.size() < most) return;
    image.resize(std::min(image.size(), most));
    whole = true;
  }
};

}  // namespace

Result<std::vector<Bytes>> read_all_sii_images(Link& link, std::uint16_t first, int count) {
  std::vector<Interface> stations(static_cast<std::size_t>(count));
  std::vector<Growing> growing(stations.size());
  if (auto ok = wait_idle(link, first, stations); !ok) return tl::unexpected(ok.error());
  for (std::uint32_t word = 0; !std::ranges::all_of(growing, &Growing::whole);) {
    const auto words = read_words(link, first, stations, word);
    if (!words) return tl::unexpected(words.error());
    for (std::size_t i = 0; i < stations.size(); ++i)
      growing[i].add(std::span<const std::byte>(stations[i]).subspan(6, 2 * *words));
    word += static_cast<std::uint32_t>(*words);
  }
  std::vector<Bytes> images;
  for (Growing& g : growing) images.push_back(std::move(g.image));
  return images;
}

Result<Bytes> read_sii_image(Link& link, std::uint16_t station) {
  auto images = read_all_sii_images(link, station, 1);
  if (!images) return tl::unexpected(images.error());
  return std::move(images->front());
}

Result<void> take_eeprom(Link& link, std::uint16_t station) {
  if (auto ok = link.write<std::uint8_t>(station, reg::kSiiConfig, kSiiTakeAway); !ok) return ok;
  return link.write<std::uint8_t>(station, reg::kSiiConfig, 0);
}

Result<void> give_eeprom(Link& link, std::uint16_t station) {
  return link.write<std::uint8_t>(station, reg::kSiiConfig, kSiiToStation);
}

}  // namespace gantry::devices
