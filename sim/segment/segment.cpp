#include "sim/segment/segment.hpp"

#include <algorithm>
#include <array>
#include <cassert>

#include "sim/drive/drive402.hpp"
#include "sim/station/station.hpp"

namespace gantry::sim {

namespace {

constexpr Time kPowerStagger = microseconds(137);  // local clocks do not start together
constexpr double kFar = 1e9;

config::SimAxis free_axis() {
  config::SimAxis truth;
  truth.neg_limit = -kFar, truth.pos_limit = kFar, truth.home_switch = -kFar;
  return truth;
}

}  // namespace

Segment::Segment(const config::Machine& machine, Clock& clock) : machine_(machine), clock_(clock) {
  std::vector<const config::Station*> stations;
  for (const auto& s : machine.stations)
    if (s.bus == config::BusKind::EtherCat) stations.push_back(&s);
  std::stable_sort(stations.begin(), stations.end(), [](auto* a, auto* b) { return a->position < b->position; });
  for (const auto* s : stations) ids_.push_back(s->id);

  std::vector<std::vector<DriveWiring>> wiring(stations.size());
  for (std::size_t i = 0; i < stations.size(); ++i)
    wiring[i].resize(stations[i]->profile.drive ? static_cast<std::size_t>(stations[i]->profile.slots) : 0);
  for (const auto& axis : machine.axes) {
    auto& of_axis = drives_.emplace_back();
    for (const auto& ref : axis.drives) {
      AxisDrive& d = of_axis.emplace_back();
      const int position = position_of(ref.station);
      if (position < 0 || ref.slot >= static_cast<int>(wiring[static_cast<std::size_t>(position)].size())) continue;
      const bool told = axis.id.value < machine.sim.axes.size();
      motors_.push_back(std::make_unique<Motor>(told ? machine.sim.axes[axis.id.value] : free_axis()));
      d = {position, ref.slot, motors_.back().get()};
      wiring[static_cast<std::size_t>(position)][static_cast<std::size_t>(ref.slot)] = {d.motor, axis.counts_per_unit,
                                                                                        ref.invert};
    }
  }
  for (std::size_t i = 0; i < stations.size(); ++i) {
    for (auto& w : wiring[i]) {
      if (w.motor != nullptr) continue;  // a slot that carries no axis turns freely
      motors_.push_back(std::make_unique<Motor>(free_axis()));
      w = {motors_.back().get(), static_cast<double>(stations[i]->profile.drive->counts_per_rev), false};
    }
    ring_.push_back(std::make_unique<Station>(*stations[i], static_cast<std::uint32_t>(stations[i]->id.value + 1),
                                              std::move(wiring[i])));
  }
  nodes_.resize(ring_.size());
  route_.reserve(ring_.size());
  datagrams_.reserve(Datagram::kMostOfAFrame);
  for (int i = 1; i < station_count(); ++i) {
    nodes_[static_cast<std::size_t>(i)].parent = i - 1;
    nodes_[static_cast<std::size_t>(i - 1)].child[1] = i;
  }
  renew();
}

void Segment::renew() {
  link_cut_.assign(ring_.size(), false);
  power_returns_.assign(ring_.size(), kNever);
  next_return_ = kNever;
  cycles_ = frames_ = 0;
  faults_ = {};
  fate_ = {};
  for (int i = 0; i < station_count(); ++i) {
    station(i).renew();
    station(i).power_on(clock_.now() - i * kPowerStagger);
  }
  update_links();
}

Segment::~Segment() = default;

// --- Time
// -------------------------------------------------------------------------------------------------------------

void Segment::advance() noexcept { advance_to(clock_.now()); }

Time Segment::next_tick() const noexcept {
  Time tick = kNever;
  for (const auto& s : ring_) tick = std::min(tick, s->next_tick());
  return tick;
}

void Segment::advance_to(Time now) noexcept {
  for (Time tick = next_tick(); std::min(tick, next_return_) <= now; tick = next_tick()) {
    if (next_return_ <= tick)
      power_returns();
    else
      tick_group(tick);
  }
  for (const auto& s : ring_)
    if (s->powered()) s->supervise(now);
}

/// The station that is next to have its supply again has it.
void Segment::power_returns() noexcept {
  const auto back = std::min_element(power_returns_.begin(), power_returns_.end());
  ring_[static_cast<std::size_t>(back - power_returns_.begin())]->power_on(*back);
  set_return(static_cast<int>(back - power_returns_.begin()), kNever);
  update_links();
}

void Segment::set_return(int position, Time at) noexcept {
  power_returns_[static_cast<std::size_t>(position)] = at;
  next_return_ = *std::min_element(power_returns_.begin(), power_returns_.end());
}

/// Everything that happens at one instant: motors arrive, outputs take effect, the world looks, inputs are sampled,
/// drives take what comes next.
void Segment::tick_group(Time at) noexcept {
  std::array<Station*, 256> due;
  std::size_t count = 0;
  const Station* lead = nullptr;
  for (const auto& s : ring_) {
    if (!s->powered()) continue;
    if (lead == nullptr || (s->sync0_runs() && !lead->sync0_runs())) lead = s.get();
    if (s->next_tick() <= at + kTogether && count < due.size()) due[count++] = s.get();
  }
  const std::span members(due.data(), count);
  for (Station* s : members) {
    s->supervise(at);
    s->move(at);
    s->latch(at);
  }
  if (std::find(members.begin(), members.end(), lead) != members.end()) {
    if (world_ != nullptr) world_->on_sync(cycles_, at);
    ++cycles_;
  }
  for (Station* s : members) {
    s->sample();
    s->take(at);
  }
}

// --- The plant
// --------------------------------------------------------------------------------------------------------

const Segment::AxisDrive& Segment::find(AxisId axis, int drive) const noexcept {
  assert(has_motor(axis, drive));
  return drives_[axis.value][static_cast<std::size_t>(drive)];
}

bool Segment::has_motor(AxisId axis, int drive) const noexcept {
  return axis.value < drives_.size() && drive >= 0 && static_cast<std::size_t>(drive) < drives_[axis.value].size() &&
         drives_[axis.value][static_cast<std::size_t>(drive)].motor != nullptr;
}

Motor& Segment::motor(AxisId axis, int drive) noexcept { return *find(axis, drive).motor; }
const Motor& Segment::motor(AxisId axis, int drive) const noexcept { return *find(axis, drive).motor; }

Drive402* Segment::drive(AxisId axis, int drive) const noexcept {
  const AxisDrive& d = find(axis, drive);
  return ring_[static_cast<std::size_t>(d.position)]->drive(d.slot);
}

int Segment::position_of(StationId station) const noexcept {
  const auto at = std::find(ids_.begin(), ids_.end(), station);
  return at != ids_.end() ? static_cast<int>(at - ids_.begin()) : -1;
}

std::uint16_t Segment::io_outputs(StationId id) const noexcept {
  const int position = position_of(id);
  return position >= 0 ? ring_[static_cast<std::size_t>(position)]->io_outputs() : std::uint16_t{0};
}

bool Segment::in_operation(StationId id) const noexcept {
  const int position = position_of(id);
  return position >= 0 && ring_[static_cast<std::size_t>(position)]->state() == devices::wire::AlState::Op;
}

void Segment::set_io_inputs(StationId id, std::uint16_t bits) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).set_io_inputs(bits);
}

DriveMemory Segment::memory(AxisId axis, int drive_of_axis) const noexcept {
  return drive(axis, drive_of_axis)->memory();
}

void Segment::restore(AxisId axis, int drive_of_axis, const DriveMemory& memory) noexcept {
  drive(axis, drive_of_axis)->restore(memory);
}

}  // namespace gantry::sim
