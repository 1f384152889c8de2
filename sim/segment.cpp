#include "sim/segment.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

#include "devices/frame_port.hpp"
#include "devices/wire/ethercat.hpp"
#include "sim/drive402.hpp"
#include "sim/station.hpp"

namespace gantry::sim {

using namespace devices::wire;

namespace {

constexpr Time kHop{620};                          // from one station to the next: forwarding and a few metres of cable
constexpr Time kPowerStagger = microseconds(137);  // local clocks do not start together
constexpr double kFar = 1e9;

/// Bytes of the datagrams behind the two headers; 0: this is no frame that a ring would answer.
std::size_t datagram_bytes(std::span<const std::byte> frame) noexcept {
  if (frame.size() < kFrameHeader + kDatagramHeader + kWorkingCounter || frame.size() > devices::kMaxFrameBytes)
    return 0;
  if (frame[12] != std::byte{kEtherType >> 8} || frame[13] != std::byte{kEtherType & 0xFF}) return 0;
  const auto header = get_le<std::uint16_t>(frame, kEthernetHeader);
  const std::size_t length = header & kLengthMask;
  if (header >> 12 != kTypeDatagrams || length > frame.size() - kFrameHeader) return 0;
  std::size_t at = kFrameHeader;
  const std::size_t end = kFrameHeader + length;
  for (bool more = true; more;) {
    if (end - at < kDatagramHeader + kWorkingCounter) return 0;
    const DatagramHeader h = get_datagram_header(frame.subspan(at));
    if (end - at < kDatagramHeader + h.length + kWorkingCounter) return 0;
    at += kDatagramHeader + h.length + kWorkingCounter;
    more = h.more;
  }
  return length;
}

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
    ring_.push_back(std::make_unique<Station>(*stations[i], static_cast<std::uint32_t>(i + 1), std::move(wiring[i])));
    ring_.back()->power_on(clock.now() - static_cast<int>(i) * kPowerStagger);
  }
  link_cut_.resize(ring_.size());
  power_returns_.resize(ring_.size(), kNever);
  update_links();
}

Segment::~Segment() = default;

// --- Frames
// -----------------------------------------------------------------------------------------------------------

bool Segment::process(std::span<std::byte> frame) noexcept {
  const std::size_t length = datagram_bytes(frame);
  if (length == 0) return false;
  const Time now = clock_.now();
  advance_to(now);
  if (frames_to_lose_ > 0) {
    --frames_to_lose_;
    return false;
  }
  const int stations = reachable();
  if (stations == 0) return false;
  frame[6] |= std::byte{kProcessedMacBit};
  for (std::size_t at = kFrameHeader; at < kFrameHeader + length;) {
    const DatagramHeader h = get_datagram_header(frame.subspan(at));
    const std::size_t data = at + kDatagramHeader, counter = data + h.length;
    serve_datagram(frame.subspan(at, kDatagramHeader), frame.subspan(data, h.length),
                   frame.subspan(counter, kWorkingCounter), stations, now);
    at = counter + kWorkingCounter;
    if (!h.more) break;
  }
  for (int i = 0; i < stations; ++i) station(i).serve(now);
  ++frames_;
  return true;
}

void Segment::serve_datagram(std::span<std::byte> header, std::span<std::byte> data, std::span<std::byte> counter,
                             int stations, Time now) noexcept {
  DatagramHeader h = get_datagram_header(header);
  auto wkc = get_le<std::uint16_t>(counter, 0);
  std::uint16_t adp = h.adp();
  const std::uint16_t ado = h.ado();
  std::array<std::byte, devices::kMaxFrameBytes> copy;
  const auto mine = std::span(copy).first(data.size());

  const auto read = [&](Esc& esc, Time at) {
    wkc = static_cast<std::uint16_t>(wkc + (esc.read(ado, data, at) ? kWkcRead : 0));
  };
  const auto write = [&](Esc& esc, Time at) {
    wkc = static_cast<std::uint16_t>(wkc + (esc.write(ado, data, at) ? kWkcWrite : 0));
  };
  // Reads what was there and writes what came.
  const auto exchange = [&](Esc& esc, Time at) {
    std::memcpy(mine.data(), data.data(), data.size());
    if (esc.read(ado, data, at)) wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteRead);
    if (esc.write(ado, mine, at)) wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteWrite);
  };
  const auto read_or = [&](Esc& esc, Time at) {
    if (!esc.read(ado, mine, at)) return;
    for (std::size_t i = 0; i < data.size(); ++i) data[i] |= mine[i];
    wkc = static_cast<std::uint16_t>(wkc + kWkcRead);
  };

  for (int i = 0; i < stations; ++i) {
    Esc& esc = station(i).esc();
    const Time at = now + i * kHop;
    switch (h.command) {
      case Command::Aprd:
        if (adp++ == 0) read(esc, at);
        break;
      case Command::Apwr:
        if (adp++ == 0) write(esc, at);
        break;
      case Command::Aprw:
        if (adp++ == 0) exchange(esc, at);
        break;
      case Command::Fprd:
        if (esc.answers_to(adp)) read(esc, at);
        break;
      case Command::Fpwr:
        if (esc.answers_to(adp)) write(esc, at);
        break;
      case Command::Fprw:
        if (esc.answers_to(adp)) exchange(esc, at);
        break;
      case Command::Brd:
        ++adp;
        read_or(esc, at);
        break;
      case Command::Bwr:
        ++adp;
        write(esc, at);
        break;
      case Command::Brw: {
        ++adp;
        std::array<std::byte, devices::kMaxFrameBytes> came;
        std::memcpy(came.data(), data.data(), data.size());
        read_or(esc, at);
        if (esc.write(ado, std::span(came).first(data.size()), at))
          wkc = static_cast<std::uint16_t>(wkc + kWkcReadWriteWrite);
        break;
      }
      case Command::Lrd:
      case Command::Lwr:
      case Command::Lrw: wkc = static_cast<std::uint16_t>(wkc + esc.logical(h.command, h.address, data, at)); break;
      case Command::Armw:
        if (adp++ == 0)
          read(esc, at);
        else
          write(esc, at);
        break;
      case Command::Frmw:
        if (esc.answers_to(adp))
          read(esc, at);
        else
          write(esc, at);
        break;
      case Command::Nop:
      default: break;
    }
  }
  const bool logical = h.command == Command::Lrd || h.command == Command::Lwr || h.command == Command::Lrw;
  if (!logical) h.address = physical_address(adp, ado);
  put_datagram_header(header, h);
  put_le<std::uint16_t>(counter, 0, wkc);
}

// --- Time
// -------------------------------------------------------------------------------------------------------------

void Segment::advance() noexcept { advance_to(clock_.now()); }

void Segment::advance_to(Time now) noexcept {
  for (;;) {
    Time tick = kNever;
    for (const auto& s : ring_) tick = std::min(tick, s->next_tick());
    const auto back = std::min_element(power_returns_.begin(), power_returns_.end());
    if (back != power_returns_.end() && *back <= std::min(tick, now)) {
      const Time at = *back;
      *back = kNever;
      ring_[static_cast<std::size_t>(back - power_returns_.begin())]->power_on(at);
      update_links();
      continue;
    }
    if (tick > now) break;
    tick_group(tick);
  }
  for (const auto& s : ring_)
    if (s->powered()) s->supervise(now);
}

/// Everything that happens at one instant: motors arrive, outputs take effect, the world looks, inputs are sampled,
/// drives take what comes next.
void Segment::tick_group(Time at) noexcept {
  std::array<Station*, 256> due{};
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
  }
  for (Station* s : members) s->latch(at);
  if (std::find(members.begin(), members.end(), lead) != members.end()) {
    if (world_ != nullptr) world_->on_sync(cycles_, at);
    ++cycles_;
  }
  for (Station* s : members) s->sample();
  for (Station* s : members) s->take(at);
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

void Segment::set_io_inputs(StationId id, std::uint16_t bits) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).set_io_inputs(bits);
}

DriveMemory Segment::memory(AxisId axis, int drive_of_axis) const noexcept {
  return drive(axis, drive_of_axis)->memory();
}

void Segment::restore(AxisId axis, int drive_of_axis, const DriveMemory& memory) noexcept {
  drive(axis, drive_of_axis)->restore(memory);
}

// --- Script
// -----------------------------------------------------------------------------------------------------------

int Segment::reachable() const noexcept {
  int n = 0;
  while (n < station_count() && !link_cut_[static_cast<std::size_t>(n)] &&
         ring_[static_cast<std::size_t>(n)]->powered())
    ++n;
  return n;
}

bool Segment::link_up() const noexcept { return reachable() > 0; }

void Segment::update_links() noexcept {
  const auto joined = [&](int link) {  // station link - 1 with station link
    return link > 0 && link < station_count() && !link_cut_[static_cast<std::size_t>(link)] &&
           station(link - 1).powered() && station(link).powered();
  };
  const int last = reachable() - 1;
  for (int i = 0; i < station_count(); ++i) {
    if (!station(i).powered()) continue;
    const bool port0 = i == 0 ? !link_cut_[0] : joined(i);
    station(i).esc().set_links(port0, joined(i + 1), std::max(last - i, 0) * 2 * kHop);
  }
}

void Segment::cut_link(int link) noexcept {
  advance();
  if (link >= 0 && link < station_count()) link_cut_[static_cast<std::size_t>(link)] = true;
  update_links();
}

void Segment::heal_link(int link) noexcept {
  advance();
  if (link >= 0 && link < station_count()) link_cut_[static_cast<std::size_t>(link)] = false;
  update_links();
}

void Segment::power_off(StationId id) noexcept {
  advance();
  const int position = position_of(id);
  if (position < 0) return;
  power_returns_[static_cast<std::size_t>(position)] = kNever;
  station(position).power_off();
  update_links();
}

void Segment::power_on(StationId id) {
  advance();
  const int position = position_of(id);
  if (position < 0 || station(position).powered()) return;
  power_returns_[static_cast<std::size_t>(position)] = kNever;
  station(position).power_on(clock_.now());
  update_links();
}

void Segment::power_cycle(StationId id, Time dark) {
  power_off(id);
  if (const int position = position_of(id); position >= 0)
    power_returns_[static_cast<std::size_t>(position)] = clock_.now() + dark;
}

void Segment::drive_fault(AxisId axis, int drive_of_axis, std::uint32_t code) {
  drive(axis, drive_of_axis)->inject(code);
}

void Segment::set_clock_drift(StationId id, double ppm) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).esc().dc().set_drift(ppm, clock_.now());
}

}  // namespace gantry::sim
