#include "app/stations/culprits.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::stations {
namespace {

constexpr std::uint64_t kMargin = 5;  // cycles until the exchange asks each station by itself
constexpr int kMostSteps = 200;
constexpr std::size_t kMostNamed = 4;

}  // namespace

/// In which every station is looked at once.
std::uint64_t Culprits::turn() const { return bus_.station_count() + kMargin; }

void Culprits::ask(const cycle::Event& event) { asked_.push_back({event, bus_.cycles()}); }

void Culprits::watch(const cycle::Snapshot& now) {
  for (Asked& a : asked_) ++a.steps;
  if (!asked_.empty() || !now.complete || !now.operational) return;
  missed_before_.resize(bus_.station_count());
  devices::Presence presence;
  for (std::size_t i = 0; i < missed_before_.size(); ++i)
    if (bus_.presence(i, presence)) missed_before_[i] = presence.missed;
}

std::optional<Culprits::Known> Culprits::next() {
  if (asked_.empty()) return std::nullopt;
  const Asked& oldest = asked_.front();
  if (bus_.cycles() < oldest.since + turn() && oldest.steps < kMostSteps) return std::nullopt;
  Known known = name(oldest.event);
  asked_.pop_front();
  return known;
}

bool Culprits::waiting(Fault fault) const {
  return std::any_of(asked_.begin(), asked_.end(), [&](const Asked& a) { return a.event.fault == fault; });
}

Culprits::Known Culprits::name(const cycle::Event& event) const {
  Known known{event, {}, {}};
  std::size_t count = 0;
  devices::Presence presence;
  for (std::size_t i = 0; i < bus_.station_count(); ++i) {
    if (!bus_.presence(i, presence)) continue;
    const bool missing = presence.missed > (i < missed_before_.size() ? missed_before_[i] : 0);
    const bool asked = presence.asked_at != 0 && presence.asked_at + turn() + kMargin >= bus_.cycles();
    const bool left = asked && !presence.operational;
    if ((!missing && !left) || ++count > kMostNamed) continue;
    const std::string& where = bus_.station(i).where;
    known.where += (known.where.empty() ? "" : ", ") + where;
    if (left) known.what += fmt::format("; {} is {}", where, bus_.state_words(i));
  }
  if (count > kMostNamed) known.where += fmt::format(" and {} more", count - kMostNamed);
  return known;
}

}  // namespace gantry::stations
