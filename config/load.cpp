#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <map>
#include <tuple>

#include "config/machine_file.hpp"
#include "core/near_word.hpp"
#include "core/sha256.hpp"

namespace gantry::config {
namespace {

using D = Dimension;

constexpr double kBackOff_mm = 1;

/// Looks names up and turns quantities into mm or rad; every failure is a mistake at its location.
class Resolver {
 public:
  Resolver(std::string path, Mistakes& mistakes, std::vector<Error>& of_profiles)
      : folder_(std::filesystem::path(path).parent_path()), mistakes_(mistakes), of_profiles_(of_profiles) {}

  Machine resolve(const written::MachineFile& file);

 private:
  /// Index of `name` among rows that have a name; reports the nearest when there is none.
  template <class Rows>
  std::optional<std::size_t> index(const Rows& rows, const At<std::string>& name, std::string_view what) {
    if (rows.empty()) return std::nullopt;  // that their list is missing is told already
    std::vector<std::string_view> known;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].name == name.value) return i;
      known.push_back(rows[i].name);
    }
    unknown(name.value, name.location, what, known);
    return std::nullopt;
  }
  void unknown(const std::string& name, Location location, std::string_view what,
               const std::vector<std::string_view>& known) {
    mistakes_.add(Fault::UnknownReference,
                  fmt::format("there is no {} '{}'; {}", what, name, did_you_mean(name, known)), location);
  }

  /// The value of a quantity that must have one dimension.
  double value(const Quantity& quantity, Location location, D wanted) {
    if (quantity.dimension == wanted) return quantity.value;
    mistakes_.add(
        Fault::BadUnit,
        fmt::format("the axis counts in {}; write for example '{}'", units::name(wanted), units::example(wanted)),
        location);
    return 0;
  }
  double value(const At<Quantity>& quantity, D wanted) {
    return quantity.given() ? value(quantity.value, quantity.location, wanted) : 0;
  }
  double positive(const At<Quantity>& quantity, D wanted) {
    const double v = value(quantity, wanted);
    if (quantity.given() && quantity.value.dimension == wanted && !(v > 0))
      mistakes_.add(Fault::OutOfRange, "must be more than 0", quantity.location);
    return v;
  }
  std::pair<double, double> interval(const At<std::vector<Quantity>>& pair, D wanted, std::string_view what) {
    if (pair.value.size() != 2) return {0, 0};
    for (const Quantity& each : pair.value)
      if (each.dimension != wanted) return value(each, pair.location, wanted), std::pair{0.0, 0.0};
    const double low = pair.value[0].value, high = pair.value[1].value;
    if (!(low < high))
      mistakes_.add(Fault::Inconsistent, fmt::format("{}: the first must be less than the second", what),
                    pair.location);
    return {low, high};
  }

  std::optional<StationProfile> profile(const At<std::string>& name);
  void no_profiles();
  void stations(const written::MachineFile& file, Machine& m);
  void axes(const written::MachineFile& file, Machine& m);
  void homing(const written::HomingRow& row, Axis& axis);
  void counts(const written::AxisRow& row, const Axis& axis);
  void roles(const written::MachineFile& file, Machine& m);
  std::vector<Body> bodies(const std::vector<written::BodyRow>& rows);
  void sim(const written::MachineFile& file, Machine& m);
  void brake(const written::MachineFile& file, Machine& m);

  std::filesystem::path folder_;
  Mistakes& mistakes_;
  std::vector<Error>& of_profiles_;
  std::map<std::string, std::optional<StationProfile>> profiles_;
  std::vector<At<std::string>> missing_;  ///< names of profiles, where there is none at all
};

std::optional<StationProfile> Resolver::profile(const At<std::string>& name) {
  if (const auto known = profiles_.find(name.value); known != profiles_.end()) return known->second;
  std::optional<StationProfile>& slot = profiles_[name.value];
  std::vector<std::string> all;
  for (const char* kind : {"drives", "devices"}) {
    const std::string folder = profiles_beside(folder_.string(), kind);
    const auto path = std::filesystem::path(folder) / (name.value + ".yaml");
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) {
      auto read = load_profile(path.string());
      if (read)
        slot = std::move(*read);
      else
        of_profiles_.insert(of_profiles_.end(), read.error().begin(), read.error().end());
      return slot;
    }
    for (std::string& each : yaml_files_in(folder)) all.push_back(std::move(each));
  }
  std::sort(all.begin(), all.end());
  if (all.empty()) {  // it was copied without them: one mistake, whatever the number of stations
    missing_.push_back(name);
    return slot;
  }
  mistakes_.add(Fault::UnknownReference,
                fmt::format("there is no profile '{}'; looked for {}.yaml in {} and {}; {}", name.value, name.value,
                            profiles_beside(folder_.string(), "drives"), profiles_beside(folder_.string(), "devices"),
                            did_you_mean(name.value, {all.begin(), all.end()})),
                name.location);
  return slot;
}

void Resolver::no_profiles() {
  if (missing_.empty()) return;
  std::vector<std::string> names;
  for (const At<std::string>& each : missing_) names.push_back(each.value);
  mistakes_.add(
      Fault::UnknownReference,
      fmt::format("there are no profiles beside this machine file; looked in {} and {} for: {}; copy them there, "
                  "or begin with `gantry init DIR`, which makes a folder with a machine and its profiles",
                  profiles_beside(folder_.string(), "drives"), profiles_beside(folder_.string(), "devices"),
                  fmt::join(names, ", ")),
      missing_.front().location);
}

void Resolver::stations(const written::MachineFile& file, Machine& m) {
  for (const auto& row : file.stations) {
    Station station;
    station.id = {static_cast<std::uint16_t>(m.stations.size())};
    station.name = row.name;
    station.position = row.position.value;
    station.alias = static_cast<std::uint16_t>(row.alias);
    station.emergency_stop_elsewhere = row.emergency_stop_elsewhere;
    if (row.profile.given())
      if (const auto p = profile(row.profile))
        station.profile = *p, station.bus = p->bus, resolve_parameters(row, station, mistakes_);
    m.stations.push_back(std::move(station));
  }
  no_profiles();
}

void Resolver::homing(const written::HomingRow& row, Axis& axis) {
  Homing h;
  h.order = row.order;
  h.method = static_cast<std::int8_t>(row.method.value);
  h.fast = positive(row.fast, axis.rotary ? D::AngularSpeed : D::Speed);
  h.slow = positive(row.slow, axis.rotary ? D::AngularSpeed : D::Speed);
  h.acceleration = positive(row.acceleration, axis.rotary ? D::AngularAcceleration : D::Acceleration);
  h.position = value(row.position, axis.rotary ? D::Angle : D::Length);
  h.timeout_s = row.timeout_s;
  h.rack_max = row.rack_max.given() ? value(row.rack_max, axis.rotary ? D::Angle : D::Length) : racked_by_fault(axis);
  constexpr double kSquare = 5;  // times skew_max
  h.square_max =
      row.square_max.given() ? value(row.square_max, axis.rotary ? D::Angle : D::Length) : kSquare * axis.skew_max;
  h.limits_unseen = row.limits_unseen;
  axis.homing = h;
}

/// A target is a whole number of 32 bits (607Ah), and a drive counts from where it was homed.
void Resolver::counts(const written::AxisRow& row, const Axis& axis) {
  constexpr double kMost = std::numeric_limits<std::int32_t>::max();
  const double zero = axis.homing ? axis.homing->position : 0;
  const double farthest = std::max(std::abs(axis.p_min - zero), std::abs(axis.p_max - zero)) * axis.counts_per_unit;
  if (farthest <= kMost) return;
  mistakes_.add(Fault::OutOfRange,
                fmt::format("{:.4g} counts of the drive from where they begin, and a target has 32 bits: {} at most; "
                            "write a shorter travel, or correct per_rev",
                            farthest, in_units(axis, kMost / axis.counts_per_unit)),
                row.travel.location);
}

/// By per_rev; where that could not be read, which is told, or where travel and v_max both say another thing, by
/// travel.
bool is_rotary(const written::AxisRow& row) {
  const bool by_rev = row.per_rev.value.dimension == D::Angle;
  if (row.travel.value.empty()) return by_rev;
  const bool by_travel = row.travel.value.front().dimension == D::Angle,
             by_speed = row.v_max.value.dimension == D::AngularSpeed;
  return !row.per_rev.given() || (row.v_max.given() && by_speed == by_travel) ? by_travel : by_rev;
}

void Resolver::axes(const written::MachineFile& file, Machine& m) {
  for (const auto& row : file.axes) {
    Axis axis;
    axis.id = {static_cast<std::uint8_t>(m.axes.size())};
    axis.name = row.name;
    axis.kind = row.kind;
    axis.rotary = is_rotary(row);
    const D length = axis.rotary ? D::Angle : D::Length;
    double counts_per_rev = 0;
    for (const auto& d : row.drives) {
      const auto station = d.station.given() ? index(m.stations, d.station, "station") : std::nullopt;
      const bool has_drive = station && m.stations[*station].profile.drive.has_value();
      if (!station) continue;
      const StationProfile& p = m.stations[*station].profile;
      if (!has_drive) {
        if (!p.name.empty())
          mistakes_.add(Fault::Inconsistent, fmt::format("station '{}' ({}) has no drive", d.station.value, p.title),
                        d.station.location);
        continue;
      }
      if (d.slot.value >= p.slots) {
        mistakes_.add(Fault::OutOfRange, fmt::format("{} has {} axes; slots count from 0", p.title, p.slots),
                      d.slot.location);
      }
      if (counts_per_rev != 0 && counts_per_rev != p.drive->counts_per_rev)
        mistakes_.add(Fault::Inconsistent, "both drives of an axis must have the same counts per revolution",
                      d.location);
      counts_per_rev = p.drive->counts_per_rev;
      axis.drives.push_back({{static_cast<std::uint16_t>(*station)}, d.slot.value, d.invert});
    }
    axis.unit_per_rev = positive(row.per_rev, length);
    if (axis.unit_per_rev > 0) axis.counts_per_unit = counts_per_rev / axis.unit_per_rev;
    std::tie(axis.p_min, axis.p_max) = interval(row.travel, length, "travel");
    axis.v_max = positive(row.v_max, axis.rotary ? D::AngularSpeed : D::Speed);
    axis.a_max = positive(row.a_max, axis.rotary ? D::AngularAcceleration : D::Acceleration);
    axis.j_max = positive(row.j_max, axis.rotary ? D::AngularJerk : D::Jerk);
    if (row.following) {
      axis.following_base = positive(row.following->base, length);
      axis.following_per_speed_s = row.following->per_speed_s;
    }
    axis.skew_max = positive(row.skew_max, length);
    axis.response_delay_s = row.response_delay_s;
    axis.self_locking = row.self_locking;
    if (row.path_error.given()) axis.path_error = value(row.path_error, length);
    if (row.homing) homing(*row.homing, axis);
    counts(row, axis);
    m.axes.push_back(std::move(axis));
  }
}

void Resolver::roles(const written::MachineFile& file, Machine& m) {
  const auto role = [&](const At<std::string>& name, bool rotary) -> std::optional<AxisId> {
    if (!name.given()) return std::nullopt;
    const auto i = index(m.axes, name, "axis");
    if (!i) return std::nullopt;
    if (m.axes[*i].rotary != rotary)
      mistakes_.add(Fault::Inconsistent, rotary ? "the turning axis counts in deg" : "this axis must count in mm",
                    name.location);
    return m.axes[*i].id;
  };
  m.x = role(file.roles.x, false).value_or(AxisId{});
  m.y = role(file.roles.y, false).value_or(AxisId{});
  m.z = role(file.roles.z, false).value_or(AxisId{});
  m.c = role(file.roles.turn, true);
  m.u = role(file.roles.lift, false);
  m.probe.axis = role(file.probe.axis, false).value_or(AxisId{});
}

std::vector<Body> Resolver::bodies(const std::vector<written::BodyRow>& rows) {
  std::vector<Body> out;
  for (const auto& row : rows) {
    Body body;
    body.name = row.name;
    if (!row.unread && int(row.box.has_value()) + int(row.cylinder.has_value()) + int(row.capsule.has_value()) != 1)
      mistakes_.add(Fault::BadValue, fmt::format("'{}' needs exactly one of: box, cylinder, capsule", row.name),
                    row.location);
    using Kind = Shape::Kind;
    if (row.box) body.shape = {Kind::Box, *row.box};
    if (row.cylinder)
      body.shape = {Kind::Cylinder, {row.cylinder->diameter, row.cylinder->diameter, row.cylinder->height}};
    if (row.capsule) {
      body.shape = {Kind::Capsule, {row.capsule->diameter, row.capsule->diameter, row.capsule->height}};
      if (!row.unread && row.capsule->height < row.capsule->diameter)
        mistakes_.add(Fault::Inconsistent, fmt::format("capsule '{}' is less high than thick", row.name), row.location);
    }
    body.centre = row.centre;
    body.rotation_rad = row.rotation_rad;
    body.on_lift = row.on_lift;
    body.on_turn = row.on_turn;
    out.push_back(std::move(body));
  }
  return out;
}

void Resolver::sim(const written::MachineFile& file, Machine& m) {
  SimConfig& sim = m.sim;
  sim.axes.resize(m.axes.size());
  std::vector<bool> seen(m.axes.size());
  bool misnamed = false;
  for (const auto& row : file.sim.axes) {
    const auto i = index(m.axes, {row.name, row.location}, "axis");
    misnamed = misnamed || !i;
    if (!i) continue;
    const D length = m.axes[*i].rotary ? D::Angle : D::Length;
    SimAxis& axis = sim.axes[*i];
    axis.lag_s = row.lag_s;
    axis.delay_s = row.delay_s;
    axis.coast = positive(row.coast, m.axes[*i].rotary ? D::AngularAcceleration : D::Acceleration);
    std::tie(axis.neg_limit, axis.pos_limit) = interval(row.limits, length, "limits");
    axis.home_switch = row.home_switch.given() ? value(row.home_switch, length) : axis.neg_limit;
    axis.home_active_below = row.home_active_below;
    axis.start = value(row.start, length);
    seen[*i] = true;
  }
  // A row that stands twice was most likely to be the one that is missing.
  const auto told_already = mistakes_.errors();
  misnamed =
      misnamed || std::ranges::any_of(told_already, [](const Error& e) { return e.fault == Fault::DuplicateKey; });
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i] && !misnamed && !file.sim.axes.empty())  // else it is told already
      mistakes_.add(Fault::MissingKey, fmt::format("axis '{}' has no row under sim: axes:", m.axes[i].name),
                    file.axes[i].location);
  sim.valve_open_lag_s = file.sim.valve.open_lag_s;
  sim.valve_close_lag_s = file.sim.valve.close_lag_s;
  sim.height_spread_mm = file.sim.board.height_spread_mm;
  sim.tilt_spread_rad = file.sim.board.tilt_spread_rad;
  sim.placement_spread_mm = file.sim.board.placement_spread_mm;
  sim.placement_spread_rad = file.sim.board.placement_spread_rad;
  sim.camera_noise = file.sim.camera_noise;
  sim.needle_error = file.sim.tip_errors.needle;
  sim.camera_error = file.sim.tip_errors.camera;
  sim.probe_error = file.sim.tip_errors.probe;
}

void Resolver::brake(const written::MachineFile& file, Machine& m) {
  const written::BrakeRow& row = *file.brake;
  const bool outputs_read = std::none_of(file.outputs.begin(), file.outputs.end(), [](auto& o) { return o.unread; });
  if (!row.output.given() || !row.axis.given() || !outputs_read) return;
  if (m.free_outputs.empty()) {
    if (mistakes_.none())  // else it may be one that is not known for that
      mistakes_.add(Fault::UnknownReference, "there is no free output; add the brake's under `outputs`",
                    row.output.location);
    return;
  }
  const auto output = index(m.free_outputs, row.output, "free output");
  const auto axis = index(m.axes, row.axis, "axis");
  if (output && m.free_outputs[*output].channel.invert)
    mistakes_.add(Fault::Inconsistent,
                  fmt::format("output '{}' is inverted: the brake would be released whenever nobody writes it, and the "
                              "axis would fall; wire a brake that holds without current, and leave `invert` out",
                              row.output.value),
                  row.output.location);
  if (output && axis)
    m.brake = BrakeConfig{m.axes[*axis].id, static_cast<unsigned>(kOutputs + *output), row.time_s,
                          row.release_s.value_or(row.time_s)};
}

Machine Resolver::resolve(const written::MachineFile& file) {
  Machine m;
  m.name = file.name;
  m.file = mistakes_.file();
  m.bus.cycle = Time{std::llround(file.bus.cycle_s.value * 1e9)};
  m.bus.stop_after_missed_hardware = file.bus.stop_after_missed.value.hardware;
  m.bus.stop_after_missed_sim = file.bus.stop_after_missed.value.sim;
  m.bus.frames_lost_max = file.bus.frames_lost_max;
  m.bus.map = file.bus.map;
  stations(file, m);
  axes(file, m);
  roles(file, m);
  resolve_channels(file, m, mistakes_);
  for (const auto& row : file.head.tools) m.tools.push_back({row.name, row.tip, row.lift_mm.value});
  m.head = bodies(file.head.bodies);
  m.scene = bodies(file.scene);
  m.keep_out = bodies(file.keep_out);
  for (Body& zone : m.keep_out) zone.name = zone_name(zone.name), zone.keep_out = true;
  for (const auto& row : file.frames) m.frames.push_back({row.name, row.origin});
  m.camera = file.camera;
  m.probe.speed_mm_s = file.probe.speed_mm_s.value;
  m.probe.approach_mm = file.probe.approach_mm;
  m.probe.travel_mm = file.probe.travel_mm.value;
  m.probe.retract_mm = file.probe.retract_mm;
  m.probe.fast_mm_s = file.probe.fast_mm_s.value;
  m.probe.back_off_mm = file.probe.back_off_mm.given() ? file.probe.back_off_mm.value : kBackOff_mm;
  if (file.brake) brake(file, m);
  m.clearance_mm = file.clearance_mm;
  m.safe_z_mm = file.safe_z_mm.value;
  m.hold_within_s = file.hold_within_s;
  m.override_max = file.override_max;
  for (const auto& row : file.park)
    if (const auto i = index(m.axes, {row.name, row.location}, "axis"))
      m.park.emplace_back(m.axes[*i].id, value(row.quantity, m.axes[*i].rotary ? D::Angle : D::Length));
  sim(file, m);
  return m;
}

}  // namespace

Checked<Machine> load_machine(const std::string& path) {
  const auto text = read_text_file(path);
  if (!text) return tl::unexpected(std::vector{text.error()});
  Mistakes mistakes(path);
  const auto file = read_fields(*text, written::machine_fields(), mistakes, "a machine file");
  if (!file) return tl::unexpected(mistakes.errors());
  std::vector<Error> of_profiles;
  Machine machine = Resolver(path, mistakes, of_profiles).resolve(*file);
  if (mistakes.none() && of_profiles.empty()) check_machine(machine, *file, mistakes);
  std::vector<Error> all = mistakes.errors();
  all.insert(all.end(), of_profiles.begin(), of_profiles.end());
  if (!all.empty()) return tl::unexpected(std::move(all));
  machine.sha256 = sha256_hex(*text);
  return machine;
}

std::string zone_name(std::string_view name) { return "keep-out " + std::string(name); }

const Tool* find_tool(const Machine& machine, std::string_view name) {
  for (const Tool& tool : machine.tools)
    if (tool.name == name) return &tool;
  return nullptr;
}
const Axis* find_axis(const Machine& machine, std::string_view name) {
  for (const Axis& axis : machine.axes)
    if (axis.name == name) return &axis;
  return nullptr;
}
const WorkFrame* find_frame(const Machine& machine, std::string_view name) {
  for (const WorkFrame& frame : machine.frames)
    if (frame.name == name) return &frame;
  return nullptr;
}
Vec2 turn_axis(const Machine& machine) {
  const Tool* needle = find_tool(machine, "needle");
  return needle != nullptr ? flat(needle->tip) : Vec2{};
}

}  // namespace gantry::config
