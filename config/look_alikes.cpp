#include "config/look_alikes.hpp"

#include <fmt/format.h>
#include <set>

namespace gantry::config {
namespace {

/// One alias is enough: what stands in its place by mistake has another one. Of serials both must be known, because a
/// new one alone is taken for a spare part.
bool told_apart(const Station& a, const Station& b) {
  if (a.alias != b.alias) return true;
  return a.accepted && b.accepted && a.accepted->serial != 0 && b.accepted->serial != 0 &&
         a.accepted->serial != b.accepted->serial;
}

}  // namespace

bool look_alike(const Station& a, const Station& b) {
  if (a.bus != BusKind::EtherCat || b.bus != BusKind::EtherCat) return false;
  const Identity &p = a.profile.identity, &q = b.profile.identity;
  return a.profile.name == b.profile.name || (p.vendor == q.vendor && p.product == q.product);
}

std::vector<std::string> look_alikes(const Machine& machine) {
  std::vector<std::string> out;
  std::set<std::string> told;
  for (std::size_t i = 0; i < machine.stations.size(); ++i) {
    const Station& first = machine.stations[i];
    if (told.contains(first.profile.name)) continue;
    std::string names;
    for (std::size_t k = i + 1; k < machine.stations.size(); ++k)
      if (const Station& other = machine.stations[k]; look_alike(first, other) && !told_apart(first, other))
        names += fmt::format(", '{}'", other.name);
    if (names.empty()) continue;
    told.insert(first.profile.name);
    out.push_back(
        fmt::format("stations '{}'{} ({}) look alike, and no alias tells them apart: when their cables are swapped, "
                    "the one takes the "
                    "other's orders; state another `alias` for each and set it on the station (DIP switches, where it "
                    "has them), or "
                    "accept their serial numbers with `gantry commission --all --accept`",
                    first.name, names, first.profile.title));
  }
  return out;
}

}  // namespace gantry::config
