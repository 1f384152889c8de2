// What a station's SII EEPROM says: identity, names, mailbox, SyncManagers, FMMUs, PDOs, clock modes (ETG.1000.6
// tables 16-26, ETG.2010), and how it is read through the ESC (ETG.1000.4, 6.4; registers 0500h-050Fh).
//   auto image = read_sii_image(link, station.address);
//   auto sii = parse_sii(*image);                        // believes nothing: any bytes give an answer
// Off the RT side.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/drive.hpp"
#include "core/error.hpp"
#include "devices/bus.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/wire/ethercat.hpp"
#include "devices/wire/sii.hpp"

namespace gantry::devices {

struct SiiMailbox {
  std::uint16_t out_start = 0, out_bytes = 0, in_start = 0, in_bytes = 0;  ///< out: from the master
  [[nodiscard]] bool exists() const { return out_bytes != 0 && in_bytes != 0; }
};

struct SiiSyncManager {
  wire::SyncManager registers;
  std::uint8_t enable = 0, type = 0;  ///< type 1..4 is config::SyncManagerKind; 0: not used
};

struct SiiPdoEntry {
  config::ObjectAddress address;  ///< index 0: a gap
  std::string name;
  std::uint8_t data_type = 0, bit_length = 0;
};
struct SiiPdo {
  std::uint16_t index = 0;
  std::uint8_t sync_manager = wire::sii::kNoSyncManager;  ///< that carries it by default
  std::string name;
  std::vector<SiiPdoEntry> entries;
};

struct SiiDcMode {
  std::string name;
  std::uint32_t cycle0_ns = 0, shift0_ns = 0, shift1_ns = 0;
  std::int16_t factor0 = 0, factor1 = 0;  ///< of the bus cycle; 0: not stated, negative: parts of it
  std::uint16_t activate = 0;             ///< for 0980h and 0981h
};

struct StationSii {
  // the fixed words
  std::uint16_t alias = 0;
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;
  SiiMailbox mailbox, bootstrap;
  std::uint16_t protocols = 0;  ///< wire::sii::kProtocol...
  bool read = false;            ///< the fixed words were; what could not be read is named in `damage`
  bool checksum_ok = false;
  // the categories; empty until the whole EEPROM was read
  std::string group, order, name;
  std::uint8_t coe_details = 0, flags = 0;
  std::int16_t ebus_current_mA = 0;
  std::vector<std::uint8_t> fmmus;  ///< wire::sii::kFmmu...
  std::vector<SiiSyncManager> sync_managers;
  std::vector<SiiPdo> rx_pdos, tx_pdos;
  std::vector<SiiDcMode> dc_modes;
  std::string damage;  ///< what could not be read or understood, and a wrong checksum; empty: all is well

  void add_damage(std::string_view text);
  [[nodiscard]] bool has_coe() const { return mailbox.exists() && (protocols & wire::sii::kProtocolCoe) != 0; }
};

inline constexpr std::size_t kMaxSiiBytes = 64 * 1024;

/// The fixed words alone, of at least 64 bytes. Fault::SiiInvalid.
Result<StationSii> parse_sii_words(std::span<const std::byte> image);
/// All of it. Categories that run over the end, or PDOs over theirs, end the parse and are named in `damage`; what came
/// before stays. Fault::SiiInvalid when not even the fixed words are there.
Result<StationSii> parse_sii(std::span<const std::byte> image);

/// Identity and standard mailbox of a station: six reads. Fault::SiiInvalid when the EEPROM reports an error or stays
/// busy for 100 ms; also of the reads below.
Result<StationSii> read_station_sii(Link& link, std::uint16_t station);
/// The same of stations first..first+count-1 at once: they read side by side.
Result<std::vector<StationSii>> read_all_sii(Link& link, std::uint16_t first, int count);
/// The bus has the EEPROM from now on, or the station's processor has (0500h). Drives that emulate their EEPROM, or
/// read it at start-up, wait for it in INIT (AL status code 0051h).
Result<void> take_eeprom(Link& link, std::uint16_t station);
Result<void> give_eeprom(Link& link, std::uint16_t station);

/// The images of stations first..first+count-1 up to their end categories: they read side by side.
Result<std::vector<Bytes>> read_all_sii_images(Link& link, std::uint16_t first, int count);
/// Everything up to the end category, at most what the EEPROM says of its size (and kMaxSiiBytes).
Result<Bytes> read_sii_image(Link& link, std::uint16_t station);

}  // namespace gantry::devices
