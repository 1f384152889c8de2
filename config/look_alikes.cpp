#include "config/look_alikes.hpp"

#include <fmt/format.h>
#include <set>

namespace gantry::config {
namespace {

bool serials_accepted(const Station& a, const Station& b) {
  return a.accepted && b.accepted && a.accepted->serial != 0 && b.accepted->serial != 0 &&
         a.accepted->serial != b.accepted->serial;
}

/// One alias is enough: what stands in its place by mistake has another one. Of serials both must be known, because a
/// new one alone is taken for a spare part.
bool told_apart(const Station& a, const Station& b) { return a.alias != b.alias || serials_accepted(a, b); }

/// Names of what looks like `first`, of which neither alias nor serial tells it; from `at` on.
template <class Counts>
std::string others_like(const Machine& machine, const Station& first, std::size_t at, const Counts& counts) {
  std::string names;
  for (std::size_t k = at; k < machine.stations.size(); ++k)
    if (const Station& other = machine.stations[k];
        look_alike(first, other) && !told_apart(first, other) && counts(other))
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
      words += fmt::format("{}{}: slot {}{}", words.empty() ? "" : "; ", axis.name, ref.slot,
                           ref.invert ? ", inverted" : "");
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
    const bool seen = walked(machine, first);
    const std::string unknown =
        others_like(machine, first, i + 1, [&](const Station& s) { return !seen || !walked(machine, s); });
    const std::string by_eye =
        seen ? others_like(machine, first, i + 1, [&](const Station& s) { return walked(machine, s); }) : "";
    if (unknown.empty() && by_eye.empty()) continue;
    told.insert(first.profile.name);
    if (!unknown.empty())
      out.push_back(
          fmt::format("stations '{}'{} ({}) look alike, and no alias tells them apart: when their cables are swapped, "
                      "the one takes the other's orders; state another `alias` for each and set it on the station (DIP "
                      "switches, where it has them), accept their serial numbers with `gantry commission --all "
                      "--accept`, or watch their axes move: `gantry commission --walk`",
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

std::string not_told_apart(const Machine& machine, const Station& a, std::uint32_t serial_a, const Station& b,
                           std::uint32_t serial_b) {
  if (!a.profile.drive || !b.profile.drive || !look_alike(a, b) || a.alias != b.alias) return "";
  const auto same = [](const Station& s, std::uint32_t serial) { return s.accepted && s.accepted->serial == serial; };
  const bool known = same(a, serial_a), other_known = same(b, serial_b);
  // One of two that is known leaves its own place to the other.
  if (serials_accepted(a, b) && (known || other_known)) return "";
  if (walked(machine, a) && walked(machine, b) && known && other_known) return "";
  return fmt::format(
      "'{}' and '{}' look alike, and neither an alias nor serial numbers that were accepted nor a walk tells which of "
      "them stands here: swapped, the one takes the other's orders; `gantry commission --walk`, or state an `alias` "
      "for each",
      a.name, b.name);
}

}  // namespace gantry::config
