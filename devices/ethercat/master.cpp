#include "devices/ethercat/master.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "devices/ethercat/identity_object.hpp"
#include "devices/ethercat/layout_check.hpp"
#include "devices/ethercat/leave.hpp"
#include "devices/ethercat/lrw_trial.hpp"
#include "devices/ethercat/mailbox.hpp"
#include "devices/ethercat/parameters.hpp"
#include "devices/ethercat/pdo_agreement.hpp"
#include "devices/ethercat/scan.hpp"
#include "devices/ethercat/sdo.hpp"
#include "devices/ethercat/side_by_side.hpp"
#include "devices/ethercat/slow_objects.hpp"
#include "devices/ethercat/states.hpp"
#include "devices/ethercat/station_objects.hpp"
#include "devices/ethercat/station_registers.hpp"
#include "devices/profiles/drive_entries.hpp"

namespace gantry::devices {
namespace {

using namespace wire;

constexpr std::uint32_t kLogicalStart = 0x0001'0000;
constexpr int kAway = 20;         // looks in a row: a station that restarts is away longer, and frames are lost singly
constexpr int kFreshCycles = 10;  // in a row: only then a station counts as recovered
constexpr Time kFreshTimeout = milliseconds(200);
constexpr Time kLoopBegins = milliseconds(100);

/// Errors of registers do not know whose register it was.
template <class T>
Result<T> at(const StationRecord& s, Result<T> result) {
  if (!result && result.error().where.empty()) result.error().where = s.where;
  return result;
}

}  // namespace

EthercatMaster::EthercatMaster(const config::Machine& machine, FramePort& port, Clock& clock,
                               const MasterOptions& options)
    : machine_(machine), port_(port), clock_(clock), options_(options), link_(port, clock) {}

Result<void> EthercatMaster::enter(AlState state) {
  for (const auto& s : stations_)
    if (auto ok = at(s, request_state(link_, s, state)); !ok) return ok;
  for (const auto& s : stations_)
    if (auto ok = at(s, wait_for_state(link_, s, state)); !ok) return ok;
  return {};
}

/// The same with every station at once. The first of those that failed, by position, gives the error.
Result<void> EthercatMaster::side_by_side(
    const std::function<Result<void>(StationRecord&, std::vector<std::string>&)>& work) {
  std::vector<Result<void>> results(stations_.size());
  std::vector<std::vector<std::string>> notes(stations_.size());
  SideBySide all(link_);
  for (std::size_t i = 0; i < stations_.size(); ++i)
    all.add([this, &work, &results, &notes, i] { results[i] = at(stations_[i], work(stations_[i], notes[i])); });
  all.run();
  for (auto& of_station : notes) std::ranges::move(of_station, std::back_inserter(notes_));
  for (auto& result : results)
    if (!result) return std::move(result);
  return {};
}

/// That it is the drive that its EEPROM says; then start-up objects and the mapping, as far as it takes them.
Result<void> EthercatMaster::agree(StationRecord& s, std::vector<std::string>& notes) {
  if (auto ok = check_identity_object(link_, s); !ok) return ok;
  if (auto ok = learn_pdos(s); !ok) return ok;
  if (auto ok = check_pdo_limits(s); !ok) return ok;
  if (auto ok = leave_out_absent(link_, s, notes); !ok) return ok;
  if (auto ok = write_startup(link_, s); !ok) return ok;
  if (auto ok = agree_on_pdos(link_, s, probe_slot(s), notes); !ok) return ok;
  if (auto ok = learn_foreign_outputs(link_, s, notes); !ok) return ok;
  if (auto ok = check_probe(s); !ok) return ok;
  return set_first_mode(link_, s);
}

/// The axis of this station that latches the machine's probe; nothing: none does.
std::optional<int> EthercatMaster::probe_slot(const StationRecord& s) const {
  for (const auto& axis : machine_.axes)
    if (axis.id == machine_.probe.axis)
      for (const auto& ref : axis.drives)
        if (ref.station == s.id) return ref.slot;
  return std::nullopt;
}

/// The drive at which the machine's probe hangs has to have it in its PDOs.
Result<void> EthercatMaster::check_probe(const StationRecord& s) const {
  if (s.left_out.empty() || s.config == nullptr) return {};
  for (const auto& axis : machine_.axes) {
    if (axis.id != machine_.probe.axis) continue;
    for (const auto& ref : axis.drives)
      for (const auto& address : s.left_out)
        if (ref.station == s.id && find_drive_entry(config::first_slot(s.config->profile, address, ref.slot).index))
          return fail(Fault::PdoMappingDiffers,
                      fmt::format("{:04X}h is in none of its PDOs, and axis {} has the machine's touch probe, which "
                                  "needs it in every cycle",
                                  address.index, axis.name),
                      s.where);
  }
  return {};
}

Result<void> EthercatMaster::bring_up() {
  exchanging_ = false;
  link_.ride_in(nullptr);
  notes_.clear();
  auto found = scan(link_, machine_, options_.strangers, notes_);
  if (!found) return tl::unexpected(found.error());
  forget_bent();
  stations_ = std::move(*found);
  auto up = set_up();
  if (!up) give_back_addresses(link_, stations_);
  return up;
}

/// From INIT to SAFE_OP.
Result<void> EthercatMaster::set_up() {
  for (auto& s : stations_) {
    if (auto ok = at(s, write_mailbox_setup(link_, s)); !ok) return ok;
    if (auto ok = at(s, hand_over_eeprom(link_, s)); !ok) return ok;
  }
  if (auto ok = enter(AlState::PreOp); !ok) return ok;
  if (auto ok = side_by_side([&](StationRecord& s, auto& notes) { return agree(s, notes); }); !ok) return ok;
  const auto size = lay_out(stations_, kLogicalStart, options_.map.value_or(machine_.bus.map));
  if (!size) return tl::unexpected(size.error());
  const auto lay_down = [&](StationRecord& s, auto&) {
    if (auto ok = s.bent ? Result<void>{} : check_fixed_map(link_, s); !ok) return ok;
    return write_process_data(link_, s);
  };
  if (auto ok = side_by_side(lay_down); !ok) return ok;

  const auto dc = set_up_clocks(link_, stations_, notes_);
  if (!dc) return tl::unexpected(dc.error());
  dc_ = *dc;
  if (auto ok = start_sync0(link_, stations_, dc_, machine_.bus.cycle); !ok) return ok;

  output_image_.resize(size->output_bytes);
  input_image_.assign(size->input_bytes, std::byte{0});
  spare_image_ = output_image_;
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    const StationRecord& s = stations_[i];
    if (s.config == nullptr || (!s.bent && as_loop_has_it(s.config->profile))) continue;  // null: nobody's, of a scan
    bent_.push_back({.station = i,
                     .image = std::make_unique<BentImage>(s, machine_.bus.cycle),
                     .outputs = std::span(output_image_).subspan(s.output_offset, s.output_bytes),
                     .spare = std::span(spare_image_).subspan(s.output_offset, s.output_bytes),
                     .inputs = std::span(input_image_).subspan(s.input_offset, s.input_bytes)});
  }
  clear_outputs();
  begin_cycles();
  if (auto ok = enter(AlState::SafeOp); !ok) return ok;
  const auto changed = try_lrw(link_, stations_, notes_);
  if (!changed) return tl::unexpected(changed.error());
  if (*changed > 0) begin_cycles();
  return {};
}

/// What a stranger with CoE exchanges, its objects say. Where a station of the machine file has several SyncManagers of
/// a kind and a fixed mapping, they or its EEPROM say which of them carries a PDO.
Result<void> EthercatMaster::learn_pdos(StationRecord& s) {
  const auto count = [&](config::SyncManagerKind kind) {
    return std::ranges::count_if(s.sync_managers, [&](const auto& p) { return p.is(kind); });
  };
  const bool several = count(config::SyncManagerKind::ProcessOut) > 1 || count(config::SyncManagerKind::ProcessIn) > 1;
  if (s.config != nullptr ? s.writes_mapping || !several : !s.has_coe()) return {};
  if (auto ok = read_whole_sii(link_, s); !ok) return ok;
  const auto map = devices::read_pdo_map(link_, s);
  if (!map) return tl::unexpected(map.error());
  if (s.config == nullptr && !map->from_objects) return {};
  if (s.config == nullptr) {
    s.rx_pdos.clear();
    s.tx_pdos.clear();
    for (const MappedPdo& pdo : map->pdos)
      (pdo.outputs ? s.rx_pdos : s.tx_pdos).push_back({.index = pdo.index, .slot = 0, .entries = pdo.entries});
  }
  const auto carriers = [&](const std::vector<config::PdoRow>& pdos) {
    std::vector<std::uint8_t> numbers;
    for (const auto& pdo : pdos) {
      const auto at = std::ranges::find(map->pdos, pdo.index, &MappedPdo::index);
      numbers.push_back(at != map->pdos.end() ? at->sync_manager : sii::kNoSyncManager);
    }
    return numbers;
  };
  s.rx_sync_managers = carriers(s.rx_pdos);
  s.tx_sync_managers = carriers(s.tx_pdos);
  return {};
}

void EthercatMaster::begin_cycles() {
  std::size_t ids = machine_.stations.size();
  for (const auto& s : stations_) ids = std::max<std::size_t>(ids, s.id.value + 1u);
  image_parts_.assign(ids, ImagePart{.index = kMaxCyclicStations});
  const auto bent_at = [&](std::size_t i) -> BentImage* {
    const auto found = std::ranges::find(bent_, i, &Bent::station);
    return found != bent_.end() ? found->image.get() : nullptr;
  };
  cyclic_stations_.clear();
  std::size_t reference = 0;
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    const StationRecord& s = stations_[i];
    if (s.address == dc_.reference_address) reference = i;
    image_parts_[s.id.value] = {s.output_offset, s.output_bytes, s.input_offset, s.input_bytes, i, bent_at(i)};
    int box = 0;
    const bool mailbox = find_sync_manager(s, config::SyncManagerKind::MailboxIn, &box) != nullptr;
    cyclic_stations_.push_back(
        {.id = s.id,
         .address = s.address,
         .logical = s.logical,
         .region_bytes = static_cast<std::uint16_t>(s.region_bytes),
         .output_at = 0,
         .input_at = static_cast<std::uint16_t>(s.input_at),
         .output_bytes = static_cast<std::uint16_t>(s.output_bytes),
         .input_bytes = static_cast<std::uint16_t>(s.input_bytes),
         .output_offset = static_cast<std::uint32_t>(s.output_offset),
         .input_offset = static_cast<std::uint32_t>(s.input_offset),
         .lrw = s.lrw,
         .clock = s.dc,
         .mailbox_status = static_cast<std::uint16_t>(
             mailbox ? reg::kSyncManager0 + kSyncManagerBytes * static_cast<std::size_t>(box) + kSmStatusOffset : 0)});
  }
  cyclic_ = std::make_unique<Cyclic>(CyclicLayout{.stations = cyclic_stations_,
                                                  .reference_address = dc_.reference_address,
                                                  .reference_station = reference,
                                                  .reference_wide = dc_.reference_wide,
                                                  .dc_time_ns = static_cast<std::uint64_t>(clock_.now().count()),
                                                  .stations_on_bus = static_cast<std::uint16_t>(stations_.size()),
                                                  .source = port_.source()},
                                     output_image_, input_image_);
}

/// While the loop exchanges in a thread of its own, datagrams ride in its frames. On a virtual clock one thread owns
/// everything: they go out by themselves between two cycles, unless whoever waits lets the loop step.
void EthercatMaster::choose_carrier() noexcept {
  link_.ride_in(exchanging_ && (stepped_ || !clock_.is_virtual()) ? &acyclic_ : nullptr);
}

void EthercatMaster::step_by(std::function<void()> step) {
  stepped_ = static_cast<bool>(step);
  link_.step_by(std::move(step));
}

Result<void> EthercatMaster::request_operation() {
  // A loop that was just started takes the port with its first exchange, and must not find this thread at it.
  const Time patience = clock_.now() + kLoopBegins;
  while (!clock_.is_virtual() && !exchanging_ && clock_.now() < patience)
    clock_.sleep_until(clock_.now() + milliseconds(1));
  choose_carrier();
  for (const auto& s : stations_) {
    const auto status = at(s, read_al_status(link_, s));
    if (!status) return tl::unexpected(status.error());
    if (status->error)
      if (auto ok = at(s, acknowledge(link_, s)); !ok) return ok;
    if (status->state == AlState::Op) continue;
    if (auto ok = at(s, request_state(link_, s, AlState::Op)); !ok) return ok;
  }
  return {};
}

Result<void> EthercatMaster::check_operation() {
  choose_carrier();
  for (const auto& s : stations_) {
    const auto status = at(s, read_al_status(link_, s));
    if (!status) return tl::unexpected(status.error());
    if (status->state != AlState::Op || status->error)
      return fail(Fault::StationLeftOp,
                  fmt::format("is in {} and not in OP: AL status code {:04X}h, {}; {}", name(status->state),
                              status->code, al_status_text(status->code), remedy_of_al_code(status->code)),
                  s.where);
  }
  return {};
}

Time EthercatMaster::first_cycle(Time not_before) const noexcept {
  if (dc_.reference_address == 0) return not_before;
  const Time cycle = machine_.bus.cycle, half = cycle / 2;
  const Time periods{(not_before - half + cycle - Time{1}) / cycle * cycle.count()};
  return periods + half;
}

void EthercatMaster::shut_down() {
  exchanging_ = false;
  link_.ride_in(nullptr);
  if (stations_.empty()) return;
  clear_outputs();
  const auto exchange = [&] { cyclic_->run(port_, acyclic_, clock_.now() + Link::kReplyTimeout); };
  exchange();
  for (std::string& left : leave_operation(link_, stations_, machine_.bus.cycle, exchange))
    notes_.push_back(std::move(left));
  forget_bent();
  stations_.clear();
}

/// Zeros, but what a station's own mapping holds beyond the profile's.
void EthercatMaster::clear_outputs() noexcept {
  std::ranges::fill(output_image_, std::byte{0});
  for (const Bent& b : bent_) b.image->begin_wire(b.outputs);
}

void EthercatMaster::forget_bent() noexcept {
  for (ImagePart& part : image_parts_) part.bent = nullptr;
  bent_.clear();
}

Result<StationRecord*> EthercatMaster::record(StationId station) {
  const auto it = std::find_if(stations_.begin(), stations_.end(), [&](auto& s) { return s.id == station; });
  if (it == stations_.end())
    return fail(Fault::StationMissing,
                fmt::format("station {} is not on this bus, or the bus is not up", station.value));
  choose_carrier();
  return &*it;
}

Result<Bytes> EthercatMaster::read_object(StationId station, config::ObjectAddress address) {
  return read_object(station, address, SdoAccess::Single);
}

Result<void> EthercatMaster::write_object(StationId station, config::ObjectAddress address,
                                          std::span<const std::byte> value) {
  return write_object(station, address, value, SdoAccess::Single);
}

// ---- recovery ----

Result<void> EthercatMaster::wait_until_fresh(const StationRecord& s) {
  const auto index = static_cast<std::size_t>(&s - stations_.data());
  const Time deadline = clock_.now() + kFreshTimeout;
  std::uint64_t seen = cyclic_->cycles();
  for (int fresh = 0; fresh < kFreshCycles;) {
    if (clock_.now() >= deadline)
      return fail(Fault::StationSilent, "is in OP again, but does not take part in the cycles", s.where);
    link_.pause(machine_.bus.cycle);
    const std::uint64_t now = cyclic_->cycles();
    if (now == seen) continue;
    seen = now;
    fresh = cyclic_->was_fresh(index) ? fresh + 1 : 0;
  }
  return {};
}

Result<void> EthercatMaster::bring_back(StationRecord& s, Whereabouts where) {
  if (where == Whereabouts::InOp) return wait_until_fresh(s);
  if (where == Whereabouts::Gone)
    return fail(Fault::StationMissing, "does not answer; check its supply and the cable before it", s.where);
  if (where == Whereabouts::Fallen && pick_up(link_, s)) return wait_until_fresh(s);
  // The time that the others kept: the reference's, or when that is the one that was away, another clock's.
  std::uint16_t source = dc_.reference_address;
  for (const auto& other : stations_)
    if (source == s.address && other.dc && &other != &s &&
        cyclic_->was_fresh(static_cast<std::size_t>(&other - stations_.data())))
      source = other.address;
  if (auto ok = replay(link_, s, dc_, source == s.address ? std::uint16_t{0} : source, machine_.bus.cycle); !ok)
    return ok;
  return wait_until_fresh(s);
}

Result<std::optional<AlStatus>> EthercatMaster::bring_back(StationId station) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  const auto where = at(**s, look_for(link_, **s));
  if (!where) return tl::unexpected(where.error());
  if (*where == Whereabouts::InOp && cyclic_->was_fresh(static_cast<std::size_t>(*s - stations_.data())))
    return std::nullopt;
  auto found = Result<AlStatus>{};
  if (*where != Whereabouts::Gone) found = at(**s, read_al_status(link_, **s));
  if (!found) return tl::unexpected(found.error());
  if (auto back = at(**s, bring_back(**s, *where)); !back) return tl::unexpected(back.error());
  return *found;
}

/// That a station has restarted is known from the first attempt, which gives it its address again; it is told when it
/// takes part, whichever attempt that was the work of.
Result<std::optional<Recovered>> EthercatMaster::recover(std::size_t i) {
  const auto back = bring_back(stations_[i].id);
  if (!back) return tl::unexpected(back.error());
  const bool restarted = std::exchange(stations_[i].restarted, false);
  if (!*back && !restarted) return std::nullopt;
  return Recovered{.found = *back ? in_words(**back) : "on its way to OP", .restarted = restarted};
}

std::vector<std::pair<StationId, Emergency>> EthercatMaster::take_emergencies() {
  choose_carrier();
  std::vector<std::pair<StationId, Emergency>> taken;
  for (std::size_t i = 0; i < stations_.size(); ++i) {
    StationRecord& s = stations_[i];
    StationHealth health;
    if (s.has_mailbox() && cyclic_->health(i, health) && health.mailbox_waiting) {
      if (!Mailbox(link_, s).drain()) s.mailbox.clean = false;
    }
    for (const Emergency& e : s.mailbox.emergencies) taken.emplace_back(s.id, e);
    s.mailbox.emergencies.clear();
  }
  return taken;
}

// ---- diagnosis ----

bool EthercatMaster::presence(std::size_t i, Presence& out) const noexcept {
  StationHealth health;
  if (!cyclic_->health(i, health)) return false;
  out = {.missed = health.stale_cycles,
         .asked_at = health.al_cycle,
         .operational = health.al_status == static_cast<std::uint16_t>(AlState::Op)};
  return true;
}

bool EthercatMaster::look(std::size_t i, StationLook& out) const noexcept {
  StationHealth health;
  if (!cyclic_->health(i, health)) return false;
  out = {.looks = health.looks, .message_waiting = health.mailbox_waiting};
  return true;
}

ErrorCounts EthercatMaster::error_counts(std::size_t i) const noexcept {
  StationHealth health;
  return cyclic_->health(i, health) ? counts_of(decode_error_counters(health.errors)) : ErrorCounts{};
}

std::string EthercatMaster::state_words(std::size_t i) const {
  StationHealth health;
  if (!cyclic_->health(i, health)) return "in a state that is not known";
  return in_words(
      {static_cast<AlState>(health.al_status & kAlStateMask), (health.al_status & kAlError) != 0, health.al_code});
}

Result<Bytes> EthercatMaster::read_object(StationId station, config::ObjectAddress address, SdoAccess access) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, sdo_upload(link_, **s, address, access));
}

Result<void> EthercatMaster::write_object(StationId station, config::ObjectAddress address,
                                          std::span<const std::byte> value, SdoAccess access) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, sdo_download(link_, **s, address, value, access));
}

Result<PdoMap> EthercatMaster::read_pdo_map(StationId station) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, devices::read_pdo_map(link_, **s));
}

Result<std::vector<ObjectDescription>> EthercatMaster::object_list(StationId station, bool with_entries) {
  auto s = record(station);
  if (!s) return tl::unexpected(s.error());
  return at(**s, read_object_list(link_, **s, with_entries));
}

Result<std::vector<ErrorCounters>> EthercatMaster::error_counters() {
  choose_carrier();
  std::vector<ErrorCounters> all;
  for (const auto& s : stations_) {
    const auto counters = at(s, read_error_counters(link_, s));
    if (!counters) return tl::unexpected(counters.error());
    all.push_back(*counters);
  }
  return all;
}

Result<std::vector<DcStatus>> EthercatMaster::dc_status() {
  choose_carrier();
  std::vector<DcStatus> all;
  for (const auto& s : stations_) {
    const auto status = at(s, read_dc_status(link_, s));
    if (!status) return tl::unexpected(status.error());
    all.push_back(*status);
  }
  return all;
}

std::optional<OtherMaster> EthercatMaster::other_master() const noexcept {
  if (const auto in_cycles = cyclic_->other_master()) return in_cycles;
  const auto& at_bring_up = link_.other_master();
  return at_bring_up ? std::optional(OtherMaster{.address = at_bring_up->address}) : std::nullopt;
}

std::uint64_t EthercatMaster::mailbox_repeats() const noexcept {
  std::uint64_t repeats = 0;
  for (const StationRecord& s : stations_) repeats += s.mailbox_repeats;
  return repeats;
}

std::span<std::byte> EthercatMaster::outputs(StationId station) noexcept {
  if (station.value >= image_parts_.size()) return {};
  const ImagePart& p = image_parts_[station.value];
  if (p.bent != nullptr) return p.bent->outputs();
  return std::span(output_image_).subspan(p.output_offset, p.output_bytes);
}

std::span<const std::byte> EthercatMaster::inputs(StationId station) const noexcept {
  if (station.value >= image_parts_.size()) return {};
  const ImagePart& p = image_parts_[station.value];
  if (p.bent != nullptr) return p.bent->inputs();
  return std::span<const std::byte>(input_image_).subspan(p.input_offset, p.input_bytes);
}

bool EthercatMaster::fresh(StationId station) const noexcept {
  return station.value < image_parts_.size() && image_parts_[station.value].index < kMaxCyclicStations &&
         cyclic_->fresh(image_parts_[station.value].index);
}

Exchange EthercatMaster::exchange(Time deadline) noexcept {
  exchanging_.store(true, std::memory_order_relaxed);
  for (const Bent& b : bent_) b.image->to_wire(b.outputs);
  const Exchange e = cyclic_->run(port_, acyclic_, deadline);
  for (const Bent& b : bent_) b.image->from_wire(b.inputs, cyclic_->fresh(b.station));
  return e;
}

bool EthercatMaster::has_slow_objects() const noexcept {
  return std::ranges::any_of(bent_, [](const Bent& b) { return !b.image->slow().empty(); });
}

InputSource EthercatMaster::source(StationId station, config::ObjectAddress input) const noexcept {
  const BentImage* const bent = station.value < image_parts_.size() ? image_parts_[station.value].bent : nullptr;
  return bent != nullptr ? bent->source(input) : InputSource::EveryCycle;
}

bool EthercatMaster::has_row(StationId station, config::ObjectAddress row) const noexcept {
  const auto of = std::ranges::find(stations_, station, &StationRecord::id);
  return of == stations_.end() ||
         std::ranges::find(of->startup, row, &config::StartupRow::address) != of->startup.end();
}

/// One step after the other on each station (false: it was the last), all of them side by side. What goes by SDO
/// because no PDO carries it is served in between, and until the last station is done: a slow mailbox holds up nobody
/// else's.
void EthercatMaster::serve_beside(const std::function<bool(StationRecord&)>& step) {
  constexpr Time kPause = milliseconds(2);
  const auto bent_of = [this](std::size_t i) -> Bent* {
    const auto b = std::ranges::find(bent_, i, &Bent::station);
    return b != bent_.end() && cyclic_->was_fresh(i) ? &*b : nullptr;
  };
  std::size_t busy = stations_.size(), late = 0;  // late: being served since somebody was busy
  SideBySide all(link_);
  for (std::size_t i = 0; i < stations_.size(); ++i)
    all.add([&, i] {
      Bent* const bent = bent_of(i);
      const auto serve = [&] {
        if (bent != nullptr && slow_object_is_due(*bent->image, clock_.now()))
          serve_slow_objects(link_, stations_[i], *bent->image);
      };
      do serve();
      while (step(stations_[i]));
      --busy;
      while (bent != nullptr && busy + late > 0) {
        link_.pause(kPause);
        // What begins when nobody is busy is not waited for: it must not be long.
        const std::size_t counts = busy > 0 ? 1 : 0;
        if (counts == 0 && !slow_objects_answer(*bent->image)) continue;
        late += counts;
        serve();
        late -= counts;
      }
    });
  all.run();
}

Result<void> EthercatMaster::compare_parameters() {
  choose_carrier();
  std::vector<std::size_t> next(stations_.size());
  std::vector<Result<void>> results(stations_.size());
  serve_beside([&](StationRecord& s) {
    const auto i = static_cast<std::size_t>(&s - stations_.data());
    if (next[i] == s.startup.size()) return false;
    results[i] = at(s, compare_held(link_, s, s.startup[next[i]++]));
    return results[i].has_value();
  });
  for (auto& result : results)
    if (!result) return std::move(result);
  return {};
}

std::vector<std::string> EthercatMaster::serve_objects() {
  std::vector<std::string> news;
  if (!has_slow_objects()) return news;
  choose_carrier();
  bool any_due = false;
  for (Bent& b : bent_) {
    const bool takes_part = cyclic_->was_fresh(b.station);
    b.unheard = takes_part ? 0 : std::min(b.unheard + 1, kAway);
    if (takes_part) tell_silence(stations_[b.station], *b.image, clock_.now(), news);
    any_due = any_due || (takes_part && slow_object_is_due(*b.image, clock_.now()));
    if (b.unheard == kAway) forget_slow_objects(*b.image);
  }
  if (any_due) serve_beside([](StationRecord&) { return false; });
  return news;
}

std::size_t EthercatMaster::spare_frames(std::span<const ImageChange> changes, std::span<FrameBytes> frames) noexcept {
  std::copy(output_image_.begin(), output_image_.end(), spare_image_.begin());
  for (const Bent& b : bent_) b.image->begin_spare();
  for (const ImageChange& change : changes) {
    if (change.station.value >= image_parts_.size()) continue;
    const ImagePart& p = image_parts_[change.station.value];
    change.apply(p.bent != nullptr ? p.bent->spare()
                                   : std::span(spare_image_).subspan(p.output_offset, p.output_bytes));
  }
  for (const Bent& b : bent_) b.image->spare_to_wire(b.spare);
  return cyclic_->spare_frames(spare_image_, frames);
}

}  // namespace gantry::devices
