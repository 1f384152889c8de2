// The EtherCAT slave controller of one virtual station: registers, RAM, SyncManagers, FMMUs, SII interface, watchdog,
// distributed clock. It knows the wire and nothing of what the station is for; that side (the "PDI") is
// sim/station.hpp.
//   esc.read(ado, bytes, now) / esc.write(ado, bytes, now)   // false: this station does not count
//   esc.logical(Command::Lrw, address, bytes, now)           // through the FMMUs; what it adds to the working counter
//   if (esc.take_events() & Esc::kAlControl) ...             // what the station has to look at
// Layouts: ETG.1000.4; values at power-on: Beckhoff ESC data sheet, section II. No allocation after construction.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/clock.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/dc_unit.hpp"

namespace gantry::sim {

class Esc {
 public:
  static constexpr int kFmmus = 8, kSyncManagers = 8;
  static constexpr std::size_t kRamBytes = 0x2000;
  /// From here on SyncManagers may lie: the digital outputs and the user RAM, then the process RAM (data sheet
  /// II, 1.1).
  static constexpr std::size_t kMemoryFrom = 0x0F00;

  enum Event : std::uint32_t {
    kAlControl = 1,             ///< 0120h was written
    kMailboxWritten = 2,        ///< a receive mailbox is full
    kMailboxRead = 4,           ///< a send mailbox was emptied
    kMailboxRepeat = 8,         ///< the master asks for the last message again
    kOutputsWritten = 16,       ///< a process-data SyncManager got its last byte
    kSyncManagersChanged = 32,  ///< 0800h..087Fh were written
    kSync0Changed = 64,         ///< 0981h was written
  };

  Esc(std::vector<std::byte> sii, bool dc);

  void power_on(Time now) noexcept;

  // --- The bus side ---
  bool read(std::uint16_t ado, std::span<std::byte> out, Time now) noexcept;
  bool write(std::uint16_t ado, std::span<const std::byte> in, Time now) noexcept;
  /// `data` is what the frame carries at `address`; reads replace it, after writes have taken it.
  std::uint16_t logical(devices::wire::Command command, std::uint32_t address, std::span<std::byte> data,
                        Time now) noexcept;
  [[nodiscard]] bool answers_to(std::uint16_t station_address) const noexcept;

  // --- The line ---
  /// `turnaround`: from the frame's way out to its way back through port 1.
  void set_links(bool port0, bool port1, Time turnaround) noexcept;
  [[nodiscard]] bool port1_open() const noexcept { return port1_open_; }

  // --- The station's side ---
  [[nodiscard]] std::uint32_t take_events() noexcept {
    const auto e = events_;
    events_ = 0;
    return e;
  }
  [[nodiscard]] std::uint16_t al_control() const noexcept { return get<std::uint16_t>(devices::wire::reg::kAlControl); }
  void set_al_status(std::uint16_t status, std::uint16_t code) noexcept;
  [[nodiscard]] const devices::wire::SyncManager& sync_manager(int i) const noexcept {
    return sync_managers_[static_cast<std::size_t>(i)];
  }
  [[nodiscard]] bool sync_manager_active(int i) const noexcept {
    return (sync_manager(i).activate & devices::wire::kSmActivateEnable) != 0;
  }
  /// Bytes that a SyncManager covers; empty when they lie outside the RAM.
  [[nodiscard]] std::span<std::byte> area(int sync_manager) noexcept;
  [[nodiscard]] bool mailbox_full(int sync_manager) const noexcept;
  /// The station has taken a received mailbox, or put one into its send mailbox.
  void set_mailbox_full(int sync_manager, bool full) noexcept;
  void acknowledge_repeat(int sync_manager) noexcept;

  // --- Watchdog of the process data ---
  /// kNever: it is off, or nothing has been written yet.
  [[nodiscard]] Time watchdog_expires() const noexcept;
  void expire_watchdog() noexcept;
  [[nodiscard]] Time outputs_written_at() const noexcept {
    return outputs_written_at_;
  }  ///< kNever: not since stop_watchdog()
  void stop_watchdog() noexcept;

  DcUnit& dc() noexcept { return dc_; }
  [[nodiscard]] const DcUnit& dc() const noexcept { return dc_; }
  [[nodiscard]] bool has_dc() const noexcept { return has_dc_; }

 private:
  template <class T>
  [[nodiscard]] T get(std::size_t at) const noexcept {
    return devices::wire::get_le<T>(memory_, at);
  }
  template <class T>
  void put(std::size_t at, std::type_identity_t<T> value) noexcept {
    devices::wire::put_le<T>(memory_, at, value);
  }

  bool read_ram(std::size_t at, std::size_t size) noexcept;
  bool write_ram(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  void refresh_registers(std::size_t at, std::size_t size, Time now) noexcept;
  bool write_registers(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  void on_register_write(std::size_t at, std::size_t size, Time now) noexcept;
  void run_sii_command() noexcept;
  void reload_fmmus() noexcept;
  void reload_sync_managers() noexcept;
  bool map_bytes(const devices::wire::Fmmu& fmmu, std::uint32_t address, std::span<std::byte> data, bool to_station,
                 Time now) noexcept;
  bool map_bits(const devices::wire::Fmmu& fmmu, std::uint32_t address, std::span<std::byte> data, bool to_station,
                Time now) noexcept;

  std::array<std::byte, devices::wire::reg::kProcessRam + kRamBytes> memory_{};
  std::vector<std::byte> sii_;
  bool has_dc_;
  DcUnit dc_;
  std::array<devices::wire::Fmmu, kFmmus> fmmus_{};  ///< as the registers say, decoded when they are written
  std::array<devices::wire::SyncManager, kSyncManagers> sync_managers_{};
  std::array<bool, kSyncManagers> mailbox_open_{};  ///< its first byte was touched, its last one not yet
  std::uint32_t events_ = 0;
  bool port1_open_ = false;
  Time turnaround_{};
  Time outputs_written_at_ = kNever;
};

}  // namespace gantry::sim
