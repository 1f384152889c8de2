// Segment: cables, ports and power, and the route that a frame takes.
#include <algorithm>

#include "sim/drive/drive402.hpp"
#include "sim/segment/segment.hpp"
#include "sim/station/station.hpp"

namespace gantry::sim {

namespace {

constexpr Time kHop{620};  // from one station to the next: forwarding and a few metres of cable (assumed)
constexpr std::array kRouteThroughPorts{3, 1, 2};

}  // namespace

void Segment::set_timing(const StationTiming& timing) noexcept {
  for (const auto& s : ring_) s->set_timing(timing);
}

void Segment::set_habits(StationId id, const StationHabits& habits) {
  const int position = position_of(id);
  if (position < 0) return;
  station(position).set_habits(habits);
  station(position).power_on(clock_.now());
  update_links();
}

void Segment::slow_mailbox(StationId id, Time by) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).slow_mailbox(by);
}

bool Segment::hang(StationId id, StationId parent_id, int port) noexcept {
  const int position = position_of(id), parent = position_of(parent_id);
  if (position < 1 || parent < 0 || parent >= position || port < 1 || port > 3) return false;
  const auto before = nodes_;
  Node& node = nodes_[static_cast<std::size_t>(position)];
  nodes_[static_cast<std::size_t>(node.parent)].child[static_cast<std::size_t>(node.port)] = -1;
  Node& to = nodes_[static_cast<std::size_t>(parent)];
  bool fits = to.child[static_cast<std::size_t>(port)] < 0;
  to.child[static_cast<std::size_t>(port)] = position;
  node.parent = parent, node.port = port;
  // Positions count in the order in which frames pass.
  int expected = 0;
  const auto count = [&](auto&& self, int at) -> void {
    fits &= at == expected++;
    for (const int p : kRouteThroughPorts)
      if (const int child = nodes_[static_cast<std::size_t>(at)].child[static_cast<std::size_t>(p)]; child >= 0)
        self(self, child);
  };
  count(count, 0);
  if (!fits) {
    nodes_ = before;
    return false;
  }
  unsigned ports = 0b0011;
  for (unsigned p = 1; p < 4; ++p)
    if (to.child[p] >= 0) ports |= 1u << p;
  station(parent).esc().set_ports(ports);
  if (station(parent).powered()) station(parent).power_on(clock_.now());  // the ESC has another port descriptor now
  update_links();
  return true;
}

void Segment::update_links() noexcept {
  const auto joined = [&](int link) {  // the cable that leads to station `link` from the one before it
    const int parent = nodes_[static_cast<std::size_t>(link)].parent;
    return !link_cut_[static_cast<std::size_t>(link)] && station(link).powered() &&
           (parent < 0 || station(parent).powered());
  };
  for (int i = 0; i < station_count(); ++i) {
    if (!station(i).powered()) continue;
    Esc& esc = station(i).esc();
    esc.set_link(0, joined(i));
    for (int port = 1; port < Esc::kPorts; ++port) {
      const int child = nodes_[static_cast<std::size_t>(i)].child[static_cast<std::size_t>(port)];
      esc.set_link(port, child >= 0 && joined(child));
    }
  }
  route_.clear();
  route_ends_nowhere_ = false;
  round_trip_ = Time{0};
  if (station_count() > 0 && joined(0)) round_trip_ = trace(0, Time{0});
  passes_foreign_frames_ = !route_.empty() && std::none_of(route_.begin(), route_.end(), [](const Hop& hop) {
    return hop.station->esc().destroys_foreign_frames();
  });
}

/// The frame enters a station through port 0, goes out and back through each open port, and leaves as it came. Returns
/// when it does.
Time Segment::trace(int i, Time entry) noexcept {
  Esc& esc = station(i).esc();
  if (!esc.port_open(0)) {
    route_ends_nowhere_ = true;  // a closed port takes nothing in
    return entry;
  }
  route_.push_back({&station(i), entry});
  std::array<Time, Esc::kPorts> times{};
  Time now = entry;
  for (const int port : kRouteThroughPorts) {
    if (!esc.port_open(port)) continue;
    const int child = nodes_[static_cast<std::size_t>(i)].child[static_cast<std::size_t>(port)];
    if (child < 0 || !esc.link(port)) {
      route_ends_nowhere_ = true;  // opened by hand, with nothing behind it
      break;
    }
    now = trace(child, now + kHop) + kHop;
    if (route_ends_nowhere_) break;
    times[static_cast<std::size_t>(port)] = now - entry;
  }
  esc.set_port_times(times);
  return now;
}

bool Segment::link_up() const noexcept { return !route_.empty(); }

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
  set_return(position, kNever);
  station(position).power_off();
  update_links();
}

void Segment::power_on(StationId id) {
  advance();
  const int position = position_of(id);
  if (position < 0 || station(position).powered()) return;
  set_return(position, kNever);
  station(position).power_on(clock_.now());
  update_links();
}

void Segment::power_cycle(StationId id, Time dark) {
  power_off(id);
  if (const int position = position_of(id); position >= 0) set_return(position, clock_.now() + dark);
}

void Segment::drive_fault(AxisId axis, int drive_of_axis, std::uint32_t code) {
  drive(axis, drive_of_axis)->inject(code);
}

void Segment::set_clock_drift(StationId id, double ppm) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).esc().dc().set_drift(ppm, clock_.now());
}

void Segment::set_clock_jitter(StationId id, std::uint32_t ns) noexcept {
  if (const int position = position_of(id); position >= 0)
    station(position).esc().dc().set_jitter(ns, static_cast<std::uint64_t>(position) + 1);
}

void Segment::count_errors(StationId id, int port, int frames) noexcept {
  const int position = position_of(id);
  if (position < 0 || port < 0 || port >= Esc::kPorts) return;
  for (int i = 0; i < frames; ++i) station(position).esc().count_error(Esc::FrameError::Invalid, port);
}

void Segment::stick_statusword(AxisId axis, int drive_of_axis, bool stuck) noexcept {
  drive(axis, drive_of_axis)->stick_statusword(stuck);
}

void Segment::ignore_writes(StationId id, std::optional<config::ObjectAddress> object) noexcept {
  if (const int position = position_of(id); position >= 0) station(position).objects().ignore_writes(object);
}

bool Segment::set_object(StationId id, config::ObjectAddress address, std::int64_t value) noexcept {
  const int position = position_of(id);
  Object* object = position >= 0 ? station(position).objects().find(address) : nullptr;
  if (object == nullptr) return false;
  object->value = fit(object->type, value);
  return true;
}

}  // namespace gantry::sim
