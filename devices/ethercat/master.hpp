// The EtherCAT master: StationBus for the EtherCAT stations of a machine, over any FramePort and Clock.
//   EthercatMaster master(machine, port, clock);
//   if (auto ok = master.bring_up(); !ok) ...        // scan, identities, mapping, clocks, SAFE_OP
//   each cycle: write outputs(), exchange(deadline), read inputs();   request_operation() once the cycle runs
// Blocking calls belong to one thread (the run thread), exchange() to the loop. Every call ends in bounded time.
#pragma once
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "devices/bus.hpp"
#include "devices/ethercat/bent_image.hpp"
#include "devices/ethercat/dc_setup.hpp"
#include "devices/ethercat/link.hpp"
#include "devices/ethercat/logical_map.hpp"
#include "devices/ethercat/recovery.hpp"
#include "devices/ethercat/states.hpp"
#include "devices/ethercat/station.hpp"
#include "devices/ethercat/survey.hpp"
#include "devices/rt/cyclic.hpp"
#include "devices/station_bus.hpp"

namespace gantry::devices {

struct MasterOptions {
  std::optional<MapKind> map{};  ///< instead of the machine file's
  bool strangers = false;        ///< a machine file without EtherCAT stations takes whatever is on the bus (see scan())
};

class EthercatMaster final : public StationBus {
 public:
  /// The three must outlive the master.
  EthercatMaster(const config::Machine& machine, FramePort& port, Clock& clock, const MasterOptions& options = {});

  Result<void> bring_up() override;
  Result<void> request_operation() override;
  Result<void> check_operation() override;
  [[nodiscard]] Time first_cycle(Time not_before) const noexcept override;
  void shut_down() override;
  Result<Bytes> read_object(StationId station, config::ObjectAddress address) override;
  Result<void> write_object(StationId station, config::ObjectAddress address,
                            std::span<const std::byte> value) override;

  /// In virtual time: what a blocking call does to let a cycle pass. With it, they ride along there too.
  void heed(std::function<bool()> ends) override { link_.heed(std::move(ends)); }
  void step_by(std::function<void()> step) override;
  /// Looks for a station that does not take part, and brings it back by replaying its record, while the loop goes on:
  /// in what state it was found; nothing when it is in OP and its inputs are fresh. It is back when it takes part and
  /// its inputs are fresh, cycle after cycle. Fault::StationMissing when it stays away; other faults are those of
  /// bring-up. Bounded: about half a second for a station that answers.
  Result<std::optional<AlStatus>> bring_back(StationId station);
  Result<std::optional<Recovered>> recover(std::size_t i) override;
  /// Takes what stations have sent unasked (emergencies) since the last call. Blocking, but cheap: only stations whose
  /// mailbox flag the cycles have seen are asked.
  std::vector<std::pair<StationId, Emergency>> take_emergencies() override;
  [[nodiscard]] InputSource source(StationId station, config::ObjectAddress input) const noexcept override;
  [[nodiscard]] bool has_row(StationId station, config::ObjectAddress row) const noexcept override;
  /// Whether there are objects that go by SDO because no PDO of a station carries them (6060h, 6061h, 603Fh, 60FDh).
  [[nodiscard]] bool has_slow_objects() const noexcept override;
  Result<void> compare_parameters() override;
  /// Writes and reads them: what the run thread does after each of its steps. Blocking; a few mailbox messages.
  std::vector<std::string> serve_objects() override;

  // Diagnosis, at any time between bring_up() and shut_down().
  Result<Bytes> read_object(StationId station, config::ObjectAddress address, SdoAccess access);
  Result<void> write_object(StationId station, config::ObjectAddress address, std::span<const std::byte> value,
                            SdoAccess access);
  Result<PdoMap> read_pdo_map(StationId station);
  Result<std::vector<ObjectDescription>> object_list(StationId station, bool with_entries = false);
  /// Of all stations, in the order of stations().
  Result<std::vector<ErrorCounters>> error_counters();
  Result<std::vector<DcStatus>> dc_status();

  [[nodiscard]] std::span<std::byte> outputs(StationId station) noexcept override;
  [[nodiscard]] std::span<const std::byte> inputs(StationId station) const noexcept override;
  [[nodiscard]] bool fresh(StationId station) const noexcept override;
  Exchange exchange(Time deadline) noexcept override;
  void arm(Time deadline) noexcept override {
    cyclic_->prepare();
    port_.arm(deadline);
  }
  std::size_t spare_frames(std::span<const ImageChange> changes, std::span<FrameBytes> frames) noexcept override;

  /// What bring-up found worth reporting (another revision, damage in an EEPROM, clocks ...), and behind it after
  /// shut_down() the stations that could not be brought to INIT.
  [[nodiscard]] const std::vector<std::string>& notes() const noexcept override { return notes_; }
  [[nodiscard]] const std::vector<StationRecord>& stations() const noexcept { return stations_; }
  [[nodiscard]] std::size_t station_count() const noexcept override { return stations_.size(); }
  [[nodiscard]] const BusStation& station(std::size_t i) const noexcept override { return stations_[i]; }
  /// What became of the frames and cycles since bring_up(). Any thread, without a lock.
  [[nodiscard]] CyclicCounts counters() const noexcept override { return cyclic_->counters(); }
  /// The same of the frames that bring-up and shutting down have sent by themselves.
  [[nodiscard]] const CyclicCounts& blocking_counters() const noexcept { return link_.counts(); }
  /// Another master whose frames came in, by its source address as it came; nothing as long as there was none.
  [[nodiscard]] std::optional<OtherMaster> other_master() const noexcept override;
  /// Replies of mailboxes that were asked for once more, and requests that were sent again, since bring_up().
  [[nodiscard]] std::uint64_t mailbox_repeats() const noexcept override;
  /// Exchanges since bring_up(). Any thread.
  [[nodiscard]] std::uint64_t cycles() const noexcept override { return cyclic_->cycles(); }
  /// What the cycles have seen of a station (index in stations()); false when it was not looked at yet. Any thread.
  bool health(std::size_t station, StationHealth& out) const noexcept { return cyclic_->health(station, out); }
  // The same in terms of any bus.
  bool presence(std::size_t i, Presence& out) const noexcept override;
  bool look(std::size_t i, StationLook& out) const noexcept override;
  [[nodiscard]] ErrorCounts error_counts(std::size_t i) const noexcept override;
  [[nodiscard]] std::string state_words(std::size_t i) const override;

 private:
  struct ImagePart {
    std::size_t output_offset = 0, output_bytes = 0, input_offset = 0, input_bytes = 0;
    std::size_t index = 0;      ///< in stations_
    BentImage* bent = nullptr;  ///< instead of these bytes, where the station has another mapping than its profile
  };
  Result<void> set_up();
  Result<void> enter(wire::AlState state);
  Result<void> side_by_side(const std::function<Result<void>(StationRecord&, std::vector<std::string>&)>& work);
  Result<void> agree(StationRecord& station, std::vector<std::string>& notes);
  [[nodiscard]] std::optional<int> probe_slot(const StationRecord& station) const;
  Result<void> check_probe(const StationRecord& station) const;
  Result<void> learn_pdos(StationRecord& station);
  void clear_outputs() noexcept;
  void forget_bent() noexcept;
  void begin_cycles();
  Result<void> bring_back(StationRecord& station, Whereabouts where);
  [[nodiscard]] Result<void> wait_until_fresh(const StationRecord& station);
  [[nodiscard]] Result<StationRecord*> record(StationId station);
  void choose_carrier() noexcept;

  const config::Machine& machine_;
  FramePort& port_;
  Clock& clock_;
  MasterOptions options_;
  Link link_;
  AcyclicSlot acyclic_;
  std::vector<StationRecord> stations_;  ///< in the order of positions
  std::vector<ImagePart> image_parts_;   ///< by StationId; empty for stations of other buses
  std::vector<std::byte> output_image_, input_image_, spare_image_;
  struct Bent {
    std::size_t station = 0;  ///< in stations_
    std::unique_ptr<BentImage> image;
    int unheard = 0;                      ///< looks in a row at which it did not take part
    std::span<std::byte> outputs, spare;  ///< of the images of all stations
    std::span<const std::byte> inputs;
  };
  void serve_beside(const std::function<bool(StationRecord&)>& step);
  std::vector<Bent> bent_;
  std::vector<CyclicStation> cyclic_stations_;
  std::unique_ptr<Cyclic> cyclic_ = std::make_unique<Cyclic>();
  DcSetup dc_;
  std::vector<std::string> notes_;
  std::atomic<bool> exchanging_{false};
  bool stepped_ = false;  ///< blocking calls let the loop step
};

}  // namespace gantry::devices
