#include "config/look_alikes.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <set>

namespace gantry::config {
namespace {

bool serials_accepted(const Station& a, const Station& b) {
  return a.accepted && b.accepted && a.accepted->serial != 0 && b.accepted->serial != 0 &&
         a.accepted->serial != b.accepted->serial;
}

/// Both move the same axis together: no walk tells them apart.
bool of_one_axis(const Machine& machine, const Station& a, const Station& b) {
  const auto drives = [](const Axis& axis, StationId id) {
    return std::ranges::any_of(axis.drives, [&](const DriveRef& ref) { return ref.station == id; });
  };
  return std::ranges::any_of(machine.axes, [&](const Axis& axis) { return drives(axis, a.id) && drives(axis, b.id); });
}

/// Somebody has looked where they stand: at what they move; where a walk shows nothing, because they move one axis
/// together or none, at the two themselves, whose serials he has compared.
bool looked_at(const Machine& machine, const Station& a, const Station& b) {
  const bool walks = !wiring_of(machine, a).empty() && !wiring_of(machine, b).empty();
  if (!walks || of_one_axis(machine, a, b))
    return a.accepted && b.accepted && a.accepted->compared && b.accepted->compared;
  return walked(machine, a) && walked(machine, b);
}

/// One alias is enough: what stands in its place by mistake has another one. Of serials both must be known, because a
/// new one alone is taken for a spare part; they say where a station belongs only when somebody has looked.
bool told_apart(const Machine& machine, const Station& a, const Station& b) {
  return a.alias != b.alias || (serials_accepted(a, b) && looked_at(machine, a, b));
}

/// Names of what looks like `first`, of which neither alias nor serial tells it; from `at` on.
template <class Counts>
std::string others_like(const Machine& machine, const Station& first, std::size_t at, const Counts& counts) {
  std::string names;
  for (std::size_t k = at; k < machine.stations.size(); ++k)
    if (const Station& other = machine.stations[k];
        look_alike(first, other) && !told_apart(machine, first, other) && counts(other))
      names += fmt::format(", '{}'", other.name);
  return names;
}

}  // namespace

bool look_alike(const Station& a, const Station& b) {
  if (a.bus != BusKind::EtherCat || b.bus != BusKind::EtherCat) return false;
  const Identity &p = a.profile.identity, &q = b.profile.identity;
  return a.profile.name == b.profile.name || (p.vendor == q.vendor && p.product == q.product);
}

std::string wiring_of(const Machine& machine, const Station& station) {
  std::string words;
  for (const Axis& axis : machine.axes)
    for (const DriveRef& ref : axis.drives) {
      if (ref.station != station.id) continue;
      words += fmt::format("{}{}: slot {}{}", words.empty() ? fmt::format("position {}; ", station.position) : "; ",
                           axis.name, ref.slot, ref.invert ? ", inverted" : "");
    }
  if (words.empty()) return words;
  for (const StartupRow& row : station.profile.startup)
    if (row.name == "direction") words += fmt::format("; direction {}", row.value);
  return words;
}

bool walked(const Machine& machine, const Station& station) {
  return station.accepted && !station.accepted->walked.empty() &&
         station.accepted->walked_as == wiring_of(machine, station);
}

std::vector<std::string> look_alikes(const Machine& machine) {
  std::vector<std::string> out;
  std::set<std::string> told;
  for (std::size_t i = 0; i < machine.stations.size(); ++i) {
    const Station& first = machine.stations[i];
    if (told.contains(first.profile.name)) continue;
    const auto by_walk = [&](const Station& s) {
      return walked(machine, first) && walked(machine, s) && !of_one_axis(machine, first, s);
    };
    const std::string unknown = others_like(machine, first, i + 1, [&](const Station& s) { return !by_walk(s); });
    const std::string by_eye = others_like(machine, first, i + 1, by_walk);
    if (unknown.empty() && by_eye.empty()) continue;
    told.insert(first.profile.name);
    if (!unknown.empty())
      out.push_back(
          fmt::format("stations '{}'{} ({}) look alike, and no alias tells them apart: when their cables are swapped, "
                      "the one takes the other's orders; state another `alias` for each and set it on the station (DIP "
                      "switches, where it has them), or watch their axes move: `gantry commission --walk`; of two that "
                      "move one axis together, see which is which and accept their serial numbers: `gantry commission "
                      "--all --accept`",
                      first.name, unknown, first.profile.title));
    else
      out.push_back(
          fmt::format("stations '{}'{} ({}) look alike, and only the walk of {} has told them apart: cables "
                      "that were swapped since then show nowhere; walk again when they were touched: "
                      "`gantry commission --walk`",
                      first.name, by_eye, first.profile.title, first.accepted->walked));
  }
  return out;
}

namespace {

/// "": something tells that each stands in its place.
std::string why_not_told_apart(const Machine& machine, const Station& a, std::uint32_t serial_a, const Station& b,
                               std::uint32_t serial_b) {
  if (!a.profile.drive || !b.profile.drive || !look_alike(a, b) || a.alias != b.alias) return "";
  const auto same = [](const Station& s, std::uint32_t serial) { return s.accepted && s.accepted->serial == serial; };
  const bool known = same(a, serial_a), other_known = same(b, serial_b);
  // One of two that is known leaves its own place to the other.
  const bool pair = of_one_axis(machine, a, b);
  if (serials_accepted(a, b) && (known || other_known) && looked_at(machine, a, b)) return "";
  if (!pair && walked(machine, a) && walked(machine, b) && known && other_known) return "";
  if (pair)
    return fmt::format(
        "'{}' and '{}' look alike and move one axis together, so that no walk tells them apart: state an `alias` for "
        "each and set it on the station, or see which is which, by their serial numbers, and `gantry commission --all "
        "--accept`",
        a.name, b.name);
  return fmt::format(
      "'{}' and '{}' look alike, and neither an alias nor a walk tells which of them stands here: swapped, the one "
      "takes "
      "the other's orders; `gantry commission --walk`, or state an `alias` for each",
      a.name, b.name);
}

}  // namespace

std::vector<Alike> not_told_apart(const Machine& machine, const SerialNow& serial) {
  std::vector<Alike> out;
  for (auto a = machine.stations.begin(); a != machine.stations.end(); ++a)
    for (auto b = a + 1; b != machine.stations.end(); ++b) {
      const auto of_a = serial(*a), of_b = serial(*b);
      if (!of_a || !of_b) continue;
      if (std::string why = why_not_told_apart(machine, *a, *of_a, *b, *of_b); !why.empty())
        out.push_back({a->id, std::move(why)});
    }
  return out;
}

}  // namespace gantry::config
