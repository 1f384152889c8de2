// The EtherCAT slave controller of one virtual station: registers, RAM, SyncManagers, FMMUs, SII interface, watchdog,
// distributed clock. It knows the wire and nothing of what the station is for; that side (the "PDI") is
// sim/station/station.hpp.
//   esc.read(ado, bytes, now) / esc.write(ado, bytes, now)   // false: this station does not count
//   esc.logical(Command::Lrw, address, bytes, now)           // through the FMMUs; what it adds to the working counter
//   if (esc.take_events() & Esc::kAlControl) ...             // what the station has to look at
// Layouts: ETG.1000.4; values at power-on and rules of access: Beckhoff ESC data sheet, sections I and II, for an
// ET1100. No allocation after construction. The code stands in esc.cpp (memory), esc_registers.cpp, esc_buffers.cpp
// (SyncManagers) and esc_logical.cpp (FMMUs).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/clock.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/esc/dc_unit.hpp"
#include "sim/esc/sii_unit.hpp"

namespace gantry::sim {

/// What an ESC has of a distributed clock.
enum class ClockWidth : std::uint8_t { None, Bits32, Bits64 };

class Esc {
 public:
  static constexpr int kFmmus = 8, kSyncManagers = 8, kPorts = 4;
  static constexpr std::size_t kRamBytes = 0x2000;
  static constexpr std::size_t kMemoryBytes = devices::wire::reg::kProcessRam + kRamBytes;
  /// From here on SyncManagers may lie: the digital outputs and the user RAM, then the process RAM (data sheet
  /// II, 1.1).
  static constexpr std::size_t kMemoryFrom = 0x0F00;
  /// Between kMemoryFrom and here lie the ESC's own outputs and inputs.
  static constexpr std::size_t kUserRam = 0x0F80;

  enum Event : std::uint32_t {
    kAlControl = 1,             ///< 0120h was written
    kMailboxWritten = 2,        ///< a receive mailbox is full
    kMailboxRead = 4,           ///< a send mailbox was emptied
    kMailboxRepeat = 8,         ///< the master asks for the last message again
    kOutputsWritten = 16,       ///< a process-data SyncManager got its last byte
    kSyncManagersChanged = 32,  ///< 0800h..087Fh were written
    kSync0Changed = 64,         ///< 0981h was written
    kPortsChanged = 128,        ///< 0100h..0103h were written: loops may open or close
    kFrameEnds = 256,           ///< something lasts until the end of the frame: end_frame() is due
  };

  Esc(std::vector<std::byte> sii, ClockWidth clock);

  void power_on(Time now) noexcept;
  /// To follow with power_on(): the EEPROM as it was delivered, a clock that runs right.
  void renew() noexcept;
  void set_timing(const StationTiming& timing) noexcept { sii_.set_timing(timing); }

  // --- The bus side ---
  bool read(std::uint16_t ado, std::span<std::byte> out, Time now) noexcept;
  bool write(std::uint16_t ado, std::span<const std::byte> in, Time now) noexcept;
  /// `data` is what the frame carries at `address`; reads replace it, after writes have taken it.
  std::uint16_t logical(devices::wire::Command command, std::uint32_t address, std::span<std::byte> data,
                        Time now) noexcept {
    const bool mine = address < logical_to_ && std::uint64_t{address} + data.size() > logical_from_;
    return mine ? logical_here(command, address, data, now) : std::uint16_t{0};
  }
  [[nodiscard]] bool answers_to(std::uint16_t address) const noexcept {
    return address == address_ || address == alias_;
  }
  /// 0108h: how far from what it reads a read-write command (APRW, FPRW, BRW) writes.
  [[nodiscard]] std::uint16_t read_write_offset() const noexcept { return get<std::uint16_t>(0x0108); }
  /// After the frame in which kFrameEnds came up. True: it was the last of the three that reset the station (0040h).
  bool end_frame() noexcept;
  /// What this station ORs into the IRQ field of every datagram: its events (0210h) under its mask (0200h).
  [[nodiscard]] std::uint16_t irq() const noexcept { return irq_; }

  // --- The line ---
  /// Ports that exist on this station, bit by port; 0 and 1 unless told otherwise.
  void set_ports(unsigned mask) noexcept { ports_ = mask; }
  /// The cable at a port got or lost its link.
  void set_link(int port, bool up) noexcept;
  /// 0100h: frames that are no EtherCAT end here; else they pass, and so does the source address of all.
  [[nodiscard]] bool destroys_foreign_frames() const noexcept {
    return (get<std::uint8_t>(devices::wire::reg::kDlControl) & 1) != 0;
  }
  /// Frames go through this port; where it is closed they turn back inside the station.
  [[nodiscard]] bool port_open(int port) const noexcept { return (open_ports_ >> port & 1) != 0; }
  [[nodiscard]] bool link(int port) const noexcept { return (links_ >> port & 1) != 0; }
  /// When a frame that reached the processing unit at `now` came in at each port: the latch of 0900h uses it.
  void set_port_times(const std::array<Time, kPorts>& after_entry) noexcept { port_times_ = after_entry; }
  enum class FrameError : std::uint8_t { Invalid, Receive, Forwarded, ProcessingUnit };
  void count_error(FrameError error, int port) noexcept;

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
  /// The station locks a SyncManager that its state does not use (0807h bit 0): the bus reaches nothing under it.
  void lock_sync_manager(int i, bool locked) noexcept;
  /// The station's side of a SyncManager: the mailbox, the buffer that the bus finished last, or the one that the
  /// station fills for it. Empty when it lies outside the RAM.
  [[nodiscard]] std::span<std::byte> area(int sync_manager) noexcept;
  /// The buffer that the station has filled is the one that the bus reads from now on.
  void publish(int sync_manager) noexcept;
  [[nodiscard]] bool mailbox_full(int sync_manager) const noexcept;
  /// The station has taken a received mailbox, or put one into its send mailbox.
  void set_mailbox_full(int sync_manager, bool full) noexcept;
  void acknowledge_repeat(int sync_manager) noexcept;

  // --- Watchdog of the process data ---
  /// kNever: it is off, or nothing has been written yet.
  [[nodiscard]] Time watchdog_expires() const noexcept {
    return outputs_written_at_ == kNever || watchdog_limit_ == kNever ? kNever : outputs_written_at_ + watchdog_limit_;
  }
  void expire_watchdog() noexcept;
  [[nodiscard]] Time outputs_written_at() const noexcept {
    return outputs_written_at_;
  }  ///< kNever: not since stop_watchdog()
  void stop_watchdog() noexcept;

  DcUnit& dc() noexcept { return dc_; }
  [[nodiscard]] const DcUnit& dc() const noexcept { return dc_; }
  [[nodiscard]] bool has_dc() const noexcept { return clock_ != ClockWidth::None; }
  /// The configuration area of the SII is intact: without that the application does not start.
  /// 0500h: the station's processor has the EEPROM.
  [[nodiscard]] bool sii_is_stations() const noexcept { return sii_.is_stations(); }
  void deliver_sii(std::vector<std::byte> image) { sii_ = SiiUnit(std::move(image)); }
  /// 0980h and 0981h as they were written.
  [[nodiscard]] std::uint16_t clock_activation() const noexcept {
    return get<std::uint16_t>(devices::wire::reg::kDcCyclicUnitControl);
  }
  [[nodiscard]] bool sii_loaded() const noexcept { return sii_.loaded(); }

 private:
  /// One SyncManager while it is active: where it lies and how far the access to its buffer has come.
  struct Buffer {
    std::size_t from = 0, to = 0;
    bool locked = false, mailbox = false, bus_writes = false, watched = false;
    bool open = false;     ///< its first byte was touched, its last one not yet
    bool written = false;  ///< there is something to read
    std::uint8_t number = 3;
  };

  static constexpr std::uint16_t kDlChanged = 1u << 2, kAlChanged = 1u << 3;  ///< bits of 0210h

  template <class T>
  [[nodiscard]] T get(std::size_t at) const noexcept {
    return devices::wire::get_le<T>(memory_, at);
  }
  template <class T>
  void put(std::size_t at, std::type_identity_t<T> value) noexcept {
    devices::wire::put_le<T>(memory_, at, value);
  }

  // Registers
  bool read_registers(std::size_t at, std::span<std::byte> out, Time now) noexcept;
  bool write_registers(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  bool write_pins(std::size_t at, std::span<const std::byte> in) noexcept;
  bool write_protected(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  void update_protection() noexcept;
  void on_register_write(std::size_t at, std::size_t size, Time now) noexcept;
  void on_clock_write(std::size_t at, std::size_t size, Time now) noexcept;
  void show_clock(Time now) noexcept;
  void show_sync_managers() noexcept;
  void latch_receive_times(Time now) noexcept;
  void update_watchdog_limit() noexcept;
  void update_ports() noexcept;
  void update_addresses() noexcept;
  void update_irq() noexcept;

  // RAM and SyncManagers
  bool read_ram(std::size_t at, std::span<std::byte> out) noexcept;
  bool write_ram(std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  bool read_buffer(int i, std::size_t at, std::span<std::byte> out) noexcept;
  bool write_buffer(int i, std::size_t at, std::span<const std::byte> in, Time now) noexcept;
  /// The active SyncManager that covers `at`; -1: none. `end`: where that ends.
  [[nodiscard]] int covering(std::size_t at, std::size_t& end) const noexcept;
  void reload_sync_managers(std::size_t at, std::size_t size) noexcept;
  void update_status(int i) noexcept;

  // FMMUs
  void reload_fmmus() noexcept;
  std::uint16_t logical_here(devices::wire::Command command, std::uint32_t address, std::span<std::byte> data,
                             Time now) noexcept;
  bool map_bytes(const devices::wire::Fmmu& fmmu, std::uint32_t address, std::span<std::byte> data, bool to_station,
                 Time now) noexcept;
  bool map_bits(const devices::wire::Fmmu& fmmu, std::uint32_t address, std::span<std::byte> data, bool to_station,
                Time now) noexcept;

  // First what every frame asks for, together: a virtual bus runs once a millisecond, on a processor that has forgotten
  // it in between.
  std::uint16_t irq_ = 0;
  std::uint16_t address_ = 0, alias_ = 0;            ///< 0010h, and 0012h where that counts; else the same again
  std::uint16_t bus_events_ = 0;                     ///< 0210h
  std::uint32_t events_ = 0;                         ///< for the station
  std::uint32_t active_buffers_ = 0;                 ///< bit by SyncManager
  std::size_t protected_to_ = 0;                     ///< the bus writes nothing below this
  std::size_t reachable_to_ = kMemoryBytes;          ///< nor reaches anything from here on
  std::uint64_t logical_from_ = 0, logical_to_ = 0;  ///< all that the FMMUs map lies in [from, to)
  std::size_t active_fmmus_ = 0;
  Time outputs_written_at_ = kNever, watchdog_limit_ = kNever;
  ClockWidth clock_;
  std::array<devices::wire::Fmmu, kFmmus> fmmus_{};  ///< the active ones, decoded when they are written
  DcUnit dc_;
  std::array<devices::wire::SyncManager, kSyncManagers> sync_managers_{};
  std::array<Buffer, kSyncManagers> buffers_{};
  std::array<std::byte, kMemoryBytes> memory_{};
  std::array<std::byte, kMemoryBytes> other_side_{};  ///< buffers of three-buffer SyncManagers as the station sees them
  SiiUnit sii_;
  std::optional<std::uint8_t> reset_written_;  ///< to 0040h in this frame
  std::uint8_t reset_progress_ = 0;
  unsigned ports_ = 0b0011, links_ = 0, open_ports_ = 0, shut_ports_ = 0;
  std::array<Time, kPorts> port_times_{};
};

}  // namespace gantry::sim
