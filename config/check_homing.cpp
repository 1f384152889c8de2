// Whether a homing can be right: that an axis has one, which way its method goes, where its switch is said to stand,
// and how fast it looks for it. What cannot be right is a mistake; what surprises is a sentence of `check`.
#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>

#include "config/homing_method.hpp"
#include "config/machine_file.hpp"

namespace gantry::config {
namespace {

constexpr double kRounding = 1e-9;  // relative, of values that passed through a unit
constexpr double kSame = 1e-6;      // mm or rad

/// Where the search goes from afar in the axis' own coordinate: +1, -1; 0: nowhere.
int heads(const Axis& axis, const DriveRef& ref) {
  return homing_method(axis.homing->method).toward * (ref.invert ? -1 : 1);
}

/// The coordinate of the switch that homing looks for, as `sim` has it.
double edge_of(const Axis& axis, const SimAxis& truth) {
  if (homing_method(axis.homing->method).looks_for == HomingSwitch::Home) return truth.home_switch;
  return heads(axis, axis.drives.front()) < 0 ? truth.neg_limit : truth.pos_limit;
}

/// How far it goes past the switch until it stands.
double overrun(const Homing& h) { return h.fast * h.fast / (2 * h.acceleration); }

class HomingCheck {
 public:
  HomingCheck(const Machine& machine, const Axis& axis, const written::AxisRow& row, Mistakes& mistakes)
      : machine_(machine), axis_(axis), homing_(*axis.homing), row_(*row.homing), mistakes_(mistakes) {}

  void look(const written::AxisRow& axis_row) {
    if (sides_part(axis_row)) return;
    speeds();
    drive_units();
    room();
    if (stays() || goes_down() || wrong_end()) return;
    beyond_switches();
  }

 private:
  [[nodiscard]] bool carries() const {
    return axis_.id == machine_.x || axis_.id == machine_.y || axis_.id == machine_.z || axis_.id == machine_.u;
  }
  [[nodiscard]] std::string how() const {
    return fmt::format("method {}{}", homing_.method, axis_.drives.front().invert ? " on an inverted drive" : "");
  }
  /// "; write method 17, ..." where there is one.
  [[nodiscard]] std::string opposite_method(std::string_view where) const {
    const int other = mirrored(homing_.method);
    return other == 0 ? "" : fmt::format("; write method {}, which looks for it {}", other, where);
  }

  /// Two sides of one beam that would home to opposite ends.
  bool sides_part(const written::AxisRow& axis_row) {
    if (axis_.drives.size() != 2 || heads(axis_, axis_.drives[0]) == heads(axis_, axis_.drives[1])) return false;
    mistakes_.add(Fault::Inconsistent,
                  fmt::format("the two sides of axis {} would home in opposite directions, because one of them is "
                              "inverted and method {} goes by the drive's own counter; let both count the same way "
                              "(parameter `direction` of the station), and write `invert` for both or for none",
                              axis_.name, homing_.method),
                  axis_row.drives[1].location);
    return true;
  }

  void speeds() {
    const auto most = [&](const At<Quantity>& at, double value, double limit, std::string_view what,
                          std::string_view per) {
      if (value > limit * (1 + kRounding))
        mistakes_.add(Fault::OutOfRange,
                      fmt::format("{} is more than {} of the axis, {}; write that or less", in_units(axis_, value, per),
                                  what, in_units(axis_, limit, per)),
                      at.location);
    };
    most(row_.fast, homing_.fast, axis_.v_max, "v_max", "/s");
    most(row_.slow, homing_.slow, axis_.v_max, "v_max", "/s");
    if (!starts_too_slowly(axis_))  // then it is a_max that is wrong, and told
      most(row_.acceleration, homing_.acceleration, axis_.a_max, "a_max", "/s^2");
    if (homing_.slow > homing_.fast * (1 + kRounding))
      mistakes_.add(Fault::Inconsistent,
                    fmt::format("{} over the switch's edge is faster than {} towards it (`fast`); write less, because "
                                "the edge is found as exactly as it is slow",
                                in_units(axis_, homing_.slow, "/s"), in_units(axis_, homing_.fast, "/s")),
                    row_.slow.location);
  }

  /// Behind a limit switch is the room of an axis that passes it at full speed, or of a revolution (assumed); nobody
  /// knows of more.
  void room() {
    if (homing_method(homing_.method).looks_for == HomingSwitch::Home || homing_.fast > axis_.v_max) return;
    const double room = std::max(axis_.v_max * axis_.v_max / (2 * axis_.a_max), axis_.unit_per_rev);
    if (overrun(homing_) <= room * (1 + kRounding)) return;
    mistakes_.add(
        Fault::Inconsistent,
        fmt::format("from {} it stands {} past the limit switch: farther than from v_max with a_max, and than "
                    "one revolution ({}); write at least {}, or a slower `fast`",
                    in_units(axis_, homing_.fast, "/s"), in_units(axis_, overrun(homing_)), in_units(axis_, room),
                    in_units(axis_, homing_.fast * homing_.fast / (2 * room), "/s^2")),
        row_.acceleration.location);
  }

  /// Speeds and acceleration as whole numbers of what the drive counts in (6099h, 609Ah).
  void drive_units() {
    for (const DriveRef& ref : axis_.drives) {
      const StationProfile& profile = machine_.stations[ref.station.value].profile;
      const DriveFacts& facts = *profile.drive;
      struct Value {
        ObjectAddress object;
        double value, counts;  ///< counts/s or counts/s^2 in one unit of the object
        Location location;
        std::string_view per;
      };
      for (const Value& v :
           {Value{{0x6099, 1}, homing_.fast, facts.velocity_counts_s, row_.fast.location, "/s"},
            Value{{0x6099, 2}, homing_.slow, facts.velocity_counts_s, row_.slow.location, "/s"},
            Value{
                {0x609A, 0}, homing_.acceleration, facts.acceleration_counts_s2, row_.acceleration.location, "/s^2"}}) {
        const double unit = v.counts / std::abs(axis_.counts_per_unit);
        const ObjectRow* object = find_object(profile, v.object);
        const double least = std::max(1.0, object && object->min ? static_cast<double>(*object->min) : 1.0);
        const double most = object && object->max ? static_cast<double>(*object->max) : 4e9;
        const double whole = std::round(v.value / unit);
        if (whole >= least && whole <= most) continue;
        mistakes_.add(Fault::OutOfRange,
                      fmt::format("{} takes {} .. {} in {} here", profile.title, in_units(axis_, least * unit, v.per),
                                  in_units(axis_, most * unit, v.per), to_text(v.object)),
                      v.location);
        return;
      }
    }
  }

  /// Without a switch there is no reference: the drives of the project have no absolute encoder.
  bool stays() {
    const HomingMethod method = homing_method(homing_.method);
    if (method.toward != 0) return false;
    if (carries())
      mistakes_.add(
          Fault::Inconsistent,
          fmt::format("method {} {}, so that after each start axis {} could be anywhere and would be taken to "
                      "be at {}; write a method that looks for a switch (17 to 30)",
                      homing_.method,
                      method.index_pulse ? "finds the next index pulse, of whichever revolution"
                                         : "takes for home where the axis stands",
                      axis_.name, in_units(axis_, homing_.position)),
          row_.method.location);
    return true;
  }

  bool goes_down() {
    const int direction = heads(axis_, axis_.drives.front());
    const bool z_down = axis_.id == machine_.z && direction < 0, lift_down = axis_.id == machine_.u && direction > 0;
    if (!z_down && !lift_down) return false;
    mistakes_.add(Fault::Inconsistent,
                  fmt::format("{} looks for its switch {}: axis {} would go down towards the board, while nothing is "
                              "known of where it stands{}",
                              how(), z_down ? "downwards (Z is up positive)" : "where the lift is low", axis_.name,
                              opposite_method("on the way up")),
                  row_.method.location);
    return true;
  }

  /// The limit switch that the method finds, and the end of the travel that `position` stands at.
  bool wrong_end() {
    const HomingMethod method = homing_method(homing_.method);
    if (method.looks_for == HomingSwitch::Home) return false;
    const bool low = heads(axis_, axis_.drives.front()) < 0;
    const double slack = kSame + (method.index_pulse ? axis_.unit_per_rev : 0);
    if (low ? homing_.position <= axis_.p_min + slack : homing_.position >= axis_.p_max - slack) return false;
    mistakes_.add(
        Fault::Inconsistent,
        fmt::format(
            "{} finds the limit switch at the {} end of axis {}, {} its travel ({} .. {}), and {} is not there; "
            "write the coordinate of that switch{}",
            how(), low ? "lower" : "upper", axis_.name, low ? "below" : "above", in_units(axis_, axis_.p_min),
            in_units(axis_, axis_.p_max), in_units(axis_, homing_.position),
            mirrored(homing_.method) == 0
                ? ""
                : fmt::format(", or method {} for the switch at the other end", mirrored(homing_.method))),
        row_.position.location);
    return true;
  }

  /// An edge that is called otherwise than it stands shifts the whole travel, perhaps beyond the limit switches.
  void beyond_switches() {
    const SimAxis& truth = machine_.sim.axes[axis_.id.value];
    const double edge = edge_of(axis_, truth), shift = edge - homing_.position;
    const double low = axis_.p_min + shift, high = axis_.p_max + shift;
    const double slack = kSame + (homing_method(homing_.method).index_pulse ? axis_.unit_per_rev : 0);
    if (truth.neg_limit >= axis_.p_min || truth.pos_limit <= axis_.p_max) return;  // that is told already
    if (low >= truth.neg_limit - slack && high <= truth.pos_limit + slack) return;
    mistakes_.add(
        Fault::Inconsistent,
        fmt::format("by `sim` this switch of axis {0} stands at {1}; called {2}, the travel of {0} would be at "
                    "{3} .. {4}, beyond the limit switches ({5} .. {6}); write position: {1}, or correct sim: "
                    "axes: {0}",
                    axis_.name, in_units(axis_, edge), in_units(axis_, homing_.position), in_units(axis_, low),
                    in_units(axis_, high), in_units(axis_, truth.neg_limit), in_units(axis_, truth.pos_limit)),
        row_.position.location);
  }

  const Machine& machine_;
  const Axis& axis_;
  const Homing& homing_;
  const written::HomingRow& row_;
  Mistakes& mistakes_;
};

bool takes_method(const Machine& m, const Axis& axis) {
  return std::ranges::all_of(axis.drives, [&](const DriveRef& ref) {
    const auto& methods = m.stations[ref.station.value].profile.drive->homing_methods;
    return std::ranges::find(methods, axis.homing->method) != methods.end();
  });
}

bool can_be_streamed(const Machine& m, const Axis& axis) {
  return std::ranges::all_of(axis.drives, [&](const DriveRef& ref) {
    return std::ranges::find(m.stations[ref.station.value].profile.drive->modes, 8) !=
           m.stations[ref.station.value].profile.drive->modes.end();
  });
}

/// One that would be taken here: to the limit switch at the upper end of Z, at the lower end of every other axis.
std::string example(const Machine& m, const Axis& axis) {
  const bool up = axis.id == m.z;
  const bool positive = up != axis.drives.front().invert;
  const double beyond = axis.rotary ? units::rad(1) : 1;
  return fmt::format("homing: {{order: {}, method: {}, fast: {}, slow: {}, acceleration: {}, position: {}}}",
                     up ? 0 : 1, positive ? 18 : 17, in_units(axis, axis.v_max / 10, "/s"),
                     in_units(axis, axis.v_max / 100, "/s"), in_units(axis, axis.a_max / 4, "/s^2"),
                     in_units(axis, up ? axis.p_max + beyond : axis.p_min - beyond));
}

}  // namespace

double racked_by_fault(const Axis& axis) {
  constexpr double kSeen_s = 0.02;
  return axis.v_max * (kSeen_s + axis.v_max / (2 * axis.a_max) + axis.a_max / (2 * axis.j_max));
}

void check_homing(const Machine& m, const written::MachineFile& file, Mistakes& mistakes) {
  for (std::size_t i = 0; i < m.axes.size(); ++i) {
    const Axis& axis = m.axes[i];
    if (axis.kind != AxisKind::Streamed || !can_be_streamed(m, axis)) continue;  // what cannot be is told already
    if (axis.homing && takes_method(m, axis))
      HomingCheck(m, axis, file.axes[i], mistakes).look(file.axes[i]);
    else if (!axis.homing)
      mistakes.add(Fault::MissingKey,
                   fmt::format("'homing' is missing here: axis {} gets targets, and nothing would say where it stands; "
                               "write for example {}",
                               axis.name, example(m, axis)),
                   file.axes[i].location);
  }
}

std::vector<std::string> homing_notes(const Machine& m) {
  std::vector<std::string> out;
  for (const Axis& axis : m.axes) {
    if (!axis.homing) continue;
    const Homing& h = *axis.homing;
    const HomingMethod method = homing_method(h.method);
    if (axis.kind != AxisKind::Streamed) {
      out.push_back(
          fmt::format("warning: axis {} positions by itself, and the program does not home it: its `homing` "
                      "does nothing",
                      axis.name));
      continue;
    }
    if (method.toward == 0) {
      out.push_back(
          fmt::format("warning: axis {} homes without a switch (method {}): its coordinate is right only where "
                      "somebody has put it at {} before each start",
                      axis.name, h.method, in_units(axis, h.position)));
      continue;
    }
    if (const double search_s = (axis.p_max - axis.p_min) / h.fast + overrun(h) / h.slow; search_s > h.timeout_s)
      out.push_back(
          fmt::format("warning: axis {} takes {:.0f} s to look for its switch along its whole travel and to come "
                      "back over its edge, and homing is given up after {:.6g} s; state a longer `timeout`, or "
                      "more than {} and {} for `fast` and `slow`",
                      axis.name, search_s, h.timeout_s, in_units(axis, h.fast, "/s"), in_units(axis, h.slow, "/s")));
    if (axis.drives.size() == 2 && h.rack_max >= racked_by_fault(axis))
      out.push_back(
          fmt::format("warning: axis {} may home with one side {} farther than the other before it is stopped, as far "
                      "as a fault at v_max may leave them apart; state what the beam bears: homing.rack_max",
                      axis.name, in_units(axis, h.rack_max)));
    const SimAxis& truth = m.sim.axes[axis.id.value];
    const double edge = edge_of(axis, truth);
    if (!method.index_pulse && std::abs(edge - h.position) > kSame)
      out.push_back(
          fmt::format("warning: axis {} calls its home edge {}, and sim: axes: {} has it at {}: what the "
                      "simulated machine shows is off by the difference",
                      axis.name, in_units(axis, h.position), axis.name, in_units(axis, edge)));
    const bool one_sided = method.looks_for == HomingSwitch::Home && method.turns_at == HomingSwitch::None;
    if (one_sided && truth.home_active_below != (heads(axis, axis.drives.front()) < 0))
      out.push_back(
          fmt::format("warning: axis {} looks for its home switch on the {} side (method {}), and sim: axes: "
                      "{} has it closed on the other: homing will fail there; state home_active: {}",
                      axis.name, truth.home_active_below ? "upper" : "lower", h.method, axis.name,
                      truth.home_active_below ? "above" : "below"));
  }
  return out;
}

}  // namespace gantry::config
