#include "sim/objects/sii_image.hpp"

#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>

#include "devices/wire/ethercat.hpp"
#include "devices/wire/sii.hpp"
#include "sim/objects/pdo_map.hpp"

namespace gantry::sim {

using namespace devices::wire;
using config::PdoRow;
using config::StationProfile;
using config::SyncManagerKind;
using config::SyncManagerRow;

namespace {

using Bytes = std::vector<std::byte>;

// ETG.2010 table 7: what devices/wire/sii.hpp does not name
constexpr std::size_t kGeneralDs402Channels = 9, kGeneralPorts = 16;
constexpr std::uint8_t kMailboxRepeats = 0x04, kIdentificationInAlStatus = 0x08;

constexpr std::size_t kEepromBytes = 2048;  // 16 KiBit

template <class T>
void append(Bytes& out, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    out.push_back(static_cast<std::byte>(static_cast<std::make_unsigned_t<T>>(value) >> (8 * i) & 0xFF));
}

void append_category(Bytes& image, sii::Category type, Bytes data) {
  if (data.size() % 2 != 0) data.push_back(std::byte{0});
  append(image, static_cast<std::uint16_t>(type));
  append(image, static_cast<std::uint16_t>(data.size() / 2));
  image.insert(image.end(), data.begin(), data.end());
}

/// The string category's content; index() hands out the 1-based number under which the others name a string.
struct Strings {
  std::vector<std::string> texts;
  std::uint8_t index(const std::string& text) {
    if (text.empty() || texts.size() >= 255) return 0;
    const auto at = static_cast<std::size_t>(std::find(texts.begin(), texts.end(), text) - texts.begin());
    if (at == texts.size()) texts.push_back(text);
    return static_cast<std::uint8_t>(at + 1);
  }
  [[nodiscard]] Bytes bytes() const {
    Bytes out;
    append(out, static_cast<std::uint8_t>(texts.size()));
    for (const auto& text : texts) {
      const auto size = std::min<std::size_t>(text.size(), 255);
      append(out, static_cast<std::uint8_t>(size));
      for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::byte>(text[i]));
    }
    return out;
  }
};

std::size_t image_bytes(const std::vector<PdoRow>& pdos) {
  std::size_t bits = 0;
  for (const auto& pdo : pdos)
    for (const auto& entry : pdo.entries) bits += entry.bit_length;
  return (bits + 7) / 8;
}

const SyncManagerRow* find(const std::vector<SyncManagerRow>& rows, SyncManagerKind kind) {
  const auto at = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.kind == kind; });
  return at != rows.end() ? &*at : nullptr;
}

std::uint8_t control_of(SyncManagerKind kind) {
  switch (kind) {
    case SyncManagerKind::MailboxOut: return kSmControlMailboxOut;
    case SyncManagerKind::MailboxIn: return kSmControlMailboxIn;
    case SyncManagerKind::ProcessOut: return kSmControlOutputs;
    case SyncManagerKind::ProcessIn: return kSmControlInputs;
  }
  return 0;
}

// ETG.2010 tables 2-4: words 0000h to 003Fh.
Bytes fixed_words(const StationProfile& profile, std::uint16_t alias, std::uint32_t serial) {
  Bytes words(2 * sii::kFirstCategory);
  const auto put16 = [&](std::uint16_t word, std::uint16_t value) { put_le<std::uint16_t>(words, 2u * word, value); };
  const auto put32 = [&](std::uint16_t word, std::uint32_t value) { put_le<std::uint32_t>(words, 2u * word, value); };
  // A microcontroller on SPI; with a clock its SYNC and latch units are on (0140h).
  put16(sii::kPdiControl, profile.dc ? 0x0C05 : 0x0005);
  if (profile.dc) put16(sii::kSyncImpulse, 1000);  // 10 us, in units of 10 ns
  put16(sii::kAlias, alias);
  put16(sii::kChecksum, sii_checksum(std::span(words).first(14)));
  put32(sii::kVendor, profile.identity.vendor);
  put32(sii::kProduct, profile.identity.product);
  put32(sii::kRevision, profile.identity.revision);
  put32(sii::kSerial, serial);
  const auto rows = sync_managers(profile);
  const auto* out = find(rows, SyncManagerKind::MailboxOut);
  const auto* in = find(rows, SyncManagerKind::MailboxIn);
  if (out != nullptr && in != nullptr) {
    put16(sii::kMailboxOutStart, out->start), put16(sii::kMailboxOutSize, out->length);
    put16(sii::kMailboxInStart, in->start), put16(sii::kMailboxInSize, in->length);
    put16(sii::kMailboxProtocols, sii::kProtocolCoe);
  }
  put16(sii::kSize, kEepromBytes / 128 - 1);  // in KiBit
  put16(sii::kVersion, 1);
  return words;
}

Bytes general(const StationProfile& profile, Strings& strings, bool mailbox) {
  Bytes b(sii::kGeneralBytes);
  const std::uint8_t title = strings.index(profile.title.empty() ? profile.name : profile.title);
  put_le<std::uint8_t>(b, sii::kGeneralGroup, strings.index(profile.drive ? "Drives" : "Input and output"));
  put_le<std::uint8_t>(b, sii::kGeneralOrder, strings.index(profile.name));
  put_le<std::uint8_t>(b, sii::kGeneralName, title);
  if (mailbox) {
    const std::uint8_t mapping = profile.pdo_fixed ? 0 : sii::kCoePdoAssign | sii::kCoePdoConfig;
    put_le<std::uint8_t>(
        b, sii::kGeneralCoeDetails,
        static_cast<std::uint8_t>(sii::kCoeSdo | sii::kCoeSdoInfo | sii::kCoeCompleteAccess | mapping));
    put_le<std::uint8_t>(b, kGeneralDs402Channels, static_cast<std::uint8_t>(profile.drive ? profile.slots : 0));
  }
  put_le<std::uint8_t>(b, sii::kGeneralFlags,
                       static_cast<std::uint8_t>(kIdentificationInAlStatus | (mailbox ? kMailboxRepeats : 0)));
  put_le<std::uint16_t>(b, kGeneralPorts, 0x0011);  // ports 0 and 1: MII
  return b;
}

Bytes pdos(const StationProfile& profile, PdoDirection direction, Strings& strings) {
  Bytes out;
  const auto rows = sync_managers(profile);
  const auto kind = direction == PdoDirection::Rx ? SyncManagerKind::ProcessOut : SyncManagerKind::ProcessIn;
  const auto* row_of_sm = find(rows, kind);
  const auto sm = static_cast<std::uint8_t>(row_of_sm != nullptr ? row_of_sm - rows.data() : 0xFF);
  for (const auto& pdo : default_mapping(profile, direction)) {
    if (pdo.entries.empty()) continue;
    append(out, pdo.index);
    append(out, static_cast<std::uint8_t>(pdo.entries.size()));
    append(out, sm);
    append(out, std::uint8_t{0});
    append(out, strings.index(direction == PdoDirection::Rx ? "Outputs" : "Inputs"));
    append(out, std::uint16_t{0});
    for (const auto& entry : pdo.entries) {
      const auto* row = config::find_object(profile, config::first_slot(profile, entry.address, pdo.slot));
      append(out, entry.address.index);
      append(out, entry.address.sub);
      append(out, row != nullptr ? strings.index(row->name) : std::uint8_t{0});
      append(out, row != nullptr ? static_cast<std::uint8_t>(base_type(row->type)) : std::uint8_t{0});
      append(out, entry.bit_length);
      append(out, std::uint16_t{0});
    }
  }
  return out;
}

/// ETG.2010 table 15, 24 bytes an operation mode: SYNC0 with the cycle of the bus, and none.
Bytes clock_modes(Strings& strings, const std::optional<ClockMode>& only) {
  std::vector<std::pair<const char*, ClockMode>> modes{{"DC", {}}, {"Synchron", {.activate = 0, .factor0 = 0}}};
  if (only) modes = {{"DC", *only}};
  Bytes out;
  for (const auto& [name, mode] : modes) {
    append(out, mode.cycle0_ns);
    append(out, mode.shift0_ns);
    append(out, mode.shift1_ns);
    append(out, mode.factor1);
    append(out, mode.activate);
    append(out, mode.factor0);
    append(out, strings.index(name));
    append(out, std::uint8_t{0});
    append(out, std::uint32_t{0});
  }
  return out;
}

}  // namespace

std::vector<SyncManagerRow> sync_managers(const StationProfile& profile) {
  auto rows = profile.sync_managers;
  if (rows.empty()) {
    if (profile.drive || !profile.objects.empty())
      rows = {{SyncManagerKind::MailboxOut, 0x1000, 128}, {SyncManagerKind::MailboxIn, 0x1080, 128}};
    rows.push_back({SyncManagerKind::ProcessOut, 0x1100, 0});
    rows.push_back({SyncManagerKind::ProcessIn, 0x1400, 0});
  }
  for (auto& row : rows) {
    if (row.kind == SyncManagerKind::ProcessOut)
      row.length = static_cast<std::uint16_t>(image_bytes(default_mapping(profile, PdoDirection::Rx)));
    if (row.kind == SyncManagerKind::ProcessIn)
      row.length = static_cast<std::uint16_t>(image_bytes(default_mapping(profile, PdoDirection::Tx)));
  }
  return rows;
}

std::vector<std::byte> sii_image(const StationProfile& profile, std::uint16_t alias, std::uint32_t serial,
                                 const std::optional<ClockMode>& clock_mode) {
  const auto rows = sync_managers(profile);
  const bool mailbox = find(rows, SyncManagerKind::MailboxOut) != nullptr;
  Strings strings;
  const Bytes general_bytes = general(profile, strings, mailbox);
  const Bytes tx = pdos(profile, PdoDirection::Tx, strings), rx = pdos(profile, PdoDirection::Rx, strings);
  const Bytes clock = profile.dc ? clock_modes(strings, clock_mode) : Bytes{};

  Bytes fmmus, managers;
  for (const auto& row : rows) {
    append(managers, row.start);
    append(managers, row.length);
    append(managers, control_of(row.kind));
    append(managers, std::uint8_t{0});
    append(managers, static_cast<std::uint8_t>(row.kind == SyncManagerKind::ProcessOut && row.length == 0 ? 0 : 1));
    append(managers, static_cast<std::uint8_t>(row.kind));
  }
  // ETG.2010 table 9: 1 outputs, 2 inputs, 3 mailbox status
  if (find(rows, SyncManagerKind::ProcessOut) != nullptr) append(fmmus, std::uint8_t{1});
  if (find(rows, SyncManagerKind::ProcessIn) != nullptr) append(fmmus, std::uint8_t{2});
  if (mailbox) append(fmmus, std::uint8_t{3});

  Bytes image = fixed_words(profile, alias, serial);
  append_category(image, sii::Category::Strings, strings.bytes());
  append_category(image, sii::Category::General, general_bytes);
  append_category(image, sii::Category::Fmmu, fmmus);
  append_category(image, sii::Category::SyncManager, managers);
  if (!tx.empty()) append_category(image, sii::Category::TxPdo, tx);
  if (!rx.empty()) append_category(image, sii::Category::RxPdo, rx);
  if (!clock.empty()) append_category(image, sii::Category::Dc, clock);
  append(image, static_cast<std::uint16_t>(sii::Category::End));
  image.resize(std::max(image.size(), kEepromBytes), std::byte{0xFF});  // the rest of the chip is blank
  return image;
}

}  // namespace gantry::sim
