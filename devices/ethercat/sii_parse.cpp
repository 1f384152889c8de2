#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/sii.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::size_t kFixedBytes = 2 * std::size_t{sii::kFirstCategory};
constexpr std::size_t kMailboxWordsEnd = 2 * std::size_t{sii::kMailboxProtocols} + 2;
constexpr std::uint16_t kBootstrapOutStart = 0x0014;

std::uint16_t word(std::span<const std::byte> image, std::size_t address) {
  return get_le<std::uint16_t>(image, 2 * address);
}

SiiMailbox mailbox_at(std::span<const std::byte> image, std::size_t address) {
  return {word(image, address), word(image, address + 1), word(image, address + 2), word(image, address + 3)};
}

/// Names are shown to people: what is no printable ASCII becomes a question mark.
std::vector<std::string> parse_strings(std::span<const std::byte> data) {
  std::vector<std::string> texts;
  if (data.empty()) return texts;
  const auto count = std::to_integer<std::size_t>(data[0]);
  std::size_t at = 1;
  while (texts.size() < count && at < data.size()) {
    const auto size = std::to_integer<std::size_t>(data[at++]);
    if (size > data.size() - at) break;
    std::string text;
    for (const std::byte b : data.subspan(at, size)) {
      const char c = static_cast<char>(b);
      text += c >= 0x20 && c < 0x7F ? c : '?';
    }
    texts.push_back(std::move(text));
    at += size;
  }
  return texts;
}

struct Strings {
  std::vector<std::string> texts;
  /// 1 is the first; 0 means no string.
  [[nodiscard]] std::string at(std::byte number) const {
    const auto n = std::to_integer<std::size_t>(number);
    return n >= 1 && n <= texts.size() ? texts[n - 1] : std::string{};
  }
};

void parse_general(std::span<const std::byte> d, const Strings& strings, StationSii& s) {
  if (d.size() <= sii::kGeneralEbusCurrent + 1) {
    s.add_damage("the category 'general' is too short");
    return;
  }
  s.group = strings.at(d[sii::kGeneralGroup]);
  s.order = strings.at(d[sii::kGeneralOrder]);
  s.name = strings.at(d[sii::kGeneralName]);
  s.coe_details = std::to_integer<std::uint8_t>(d[sii::kGeneralCoeDetails]);
  s.flags = std::to_integer<std::uint8_t>(d[sii::kGeneralFlags]);
  s.ebus_current_mA = get_le<std::int16_t>(d, sii::kGeneralEbusCurrent);
}

void parse_sync_managers(std::span<const std::byte> d, StationSii& s) {
  for (std::size_t at = 0; at + sii::kSmBytes <= d.size() && s.sync_managers.size() < 16; at += sii::kSmBytes) {
    const auto row = d.subspan(at, sii::kSmBytes);
    SiiSyncManager sm;
    sm.registers.start = get_le<std::uint16_t>(row, sii::kSmStart);
    sm.registers.length = get_le<std::uint16_t>(row, sii::kSmLength);
    sm.registers.control = get_le<std::uint8_t>(row, sii::kSmControl);
    sm.enable = get_le<std::uint8_t>(row, sii::kSmEnable);
    sm.type = get_le<std::uint8_t>(row, sii::kSmType);
    s.sync_managers.push_back(sm);
  }
}

void parse_pdos(std::span<const std::byte> d, const Strings& strings, std::vector<SiiPdo>& pdos, StationSii& s) {
  for (std::size_t at = 0; at + sii::kPdoHeader <= d.size();) {
    const auto head = d.subspan(at);
    SiiPdo pdo;
    pdo.index = get_le<std::uint16_t>(head, sii::kPdoIndex);
    pdo.sync_manager = get_le<std::uint8_t>(head, sii::kPdoSyncManager);
    pdo.name = strings.at(head[sii::kPdoName]);
    const auto entries = std::to_integer<std::size_t>(head[sii::kPdoEntries]);
    at += sii::kPdoHeader;
    if (entries * sii::kEntryBytes > d.size() - at) {
      s.add_damage(fmt::format("PDO {:04X}h has more entries than its category holds", pdo.index));
      return;
    }
    for (std::size_t i = 0; i < entries; ++i, at += sii::kEntryBytes) {
      const auto e = d.subspan(at, sii::kEntryBytes);
      pdo.entries.push_back({{get_le<std::uint16_t>(e, sii::kEntryIndex), get_le<std::uint8_t>(e, sii::kEntrySub)},
                             strings.at(e[sii::kEntryName]),
                             get_le<std::uint8_t>(e, sii::kEntryType),
                             get_le<std::uint8_t>(e, sii::kEntryBits)});
    }
    pdos.push_back(std::move(pdo));
  }
}

void parse_dc(std::span<const std::byte> d, const Strings& strings, StationSii& s) {
  for (std::size_t at = 0; at + sii::kDcBytes <= d.size(); at += sii::kDcBytes) {
    const auto m = d.subspan(at, sii::kDcBytes);
    s.dc_modes.push_back({strings.at(m[sii::kDcName]), get_le<std::uint32_t>(m, sii::kDcCycle0),
                          get_le<std::uint32_t>(m, sii::kDcShift0), get_le<std::uint32_t>(m, sii::kDcShift1),
                          get_le<std::int16_t>(m, sii::kDcFactor0), get_le<std::int16_t>(m, sii::kDcFactor1),
                          get_le<std::uint16_t>(m, sii::kDcActivate)});
  }
}

struct CategoryAt {
  sii::Category type;
  std::span<const std::byte> data;
};

/// Where the categories lie. An EEPROM without an end category ends with its bytes.
std::vector<CategoryAt> find_categories(std::span<const std::byte> image, StationSii& s) {
  std::vector<CategoryAt> found;
  for (std::size_t at = kFixedBytes; at + 4 <= image.size();) {
    const auto type = static_cast<sii::Category>(get_le<std::uint16_t>(image, at));
    const std::size_t bytes = 2 * std::size_t{get_le<std::uint16_t>(image, at + 2)};
    at += 4;
    if (type == sii::Category::End) break;
    if (bytes > image.size() - at) {
      s.add_damage(fmt::format("category {} runs over the end of the EEPROM", static_cast<unsigned>(type)));
      break;
    }
    found.push_back({type, image.subspan(at, bytes)});
    at += bytes;
  }
  return found;
}

}  // namespace

void StationSii::add_damage(std::string_view text) {
  if (!damage.empty()) damage += "; ";
  damage += text;
}

Result<StationSii> parse_sii_words(std::span<const std::byte> image) {
  if (image.size() < kMailboxWordsEnd)
    return fail(Fault::SiiInvalid, fmt::format("the SII EEPROM has only {} bytes", image.size()));
  StationSii s;
  s.alias = word(image, sii::kAlias);
  s.checksum_ok = sii_checksum(image.first(14)) == (word(image, sii::kChecksum) & 0xFF);
  s.vendor = get_le<std::uint32_t>(image, 2 * sii::kVendor);
  s.product = get_le<std::uint32_t>(image, 2 * sii::kProduct);
  s.revision = get_le<std::uint32_t>(image, 2 * sii::kRevision);
  s.serial = get_le<std::uint32_t>(image, 2 * sii::kSerial);
  s.bootstrap = mailbox_at(image, kBootstrapOutStart);
  s.mailbox = mailbox_at(image, sii::kMailboxOutStart);
  s.protocols = word(image, sii::kMailboxProtocols);
  s.read = true;
  if (!s.checksum_ok)
    s.add_damage("the checksum of words 0 to 6 is wrong, so the station has not loaded its configuration");
  return s;
}

Result<StationSii> parse_sii(std::span<const std::byte> image) {
  auto parsed = parse_sii_words(image);
  if (!parsed) return parsed;
  StationSii& s = *parsed;
  const auto categories = find_categories(image, s);
  Strings strings;  // the others name them by number, wherever they stand
  for (const auto& c : categories)
    if (c.type == sii::Category::Strings) strings.texts = parse_strings(c.data);
  for (const auto& c : categories) switch (c.type) {
      case sii::Category::General: parse_general(c.data, strings, s); break;
      case sii::Category::Fmmu:
        for (const std::byte b : c.data) s.fmmus.push_back(std::to_integer<std::uint8_t>(b));
        break;
      case sii::Category::SyncManager: parse_sync_managers(c.data, s); break;
      case sii::Category::TxPdo: parse_pdos(c.data, strings, s.tx_pdos, s); break;
      case sii::Category::RxPdo: parse_pdos(c.data, strings, s.rx_pdos, s); break;
      case sii::Category::Dc: parse_dc(c.data, strings, s); break;
      default: break;  // vendor-specific, or of no use to a master
    }
  return parsed;
}

}  // namespace gantry::devices
