#include "app/stations/culprits.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace gantry::stations {
namespace {

using namespace devices::wire;

constexpr std::uint64_t kMargin = 5;  // cycles until the exchange asks each station by itself
constexpr int kMostSteps = 200;
constexpr std::size_t kMostNamed = 4;

std::string words_of(const devices::StationRecord& station, const devices::StationHealth& health) {
  const auto state = static_cast<AlState>(health.al_status & kAlStateMask);
  const std::string words = fmt::format("; {} is in {}", station.where, devices::wire::name(state));
  if (health.al_code == 0) return words;
  return words + fmt::format(": AL status code {:04X}h, {}", health.al_code, al_status_text(health.al_code));
}

}  // namespace

/// In which every station is looked at once.
std::uint64_t Culprits::turn() const { return bus_.stations().size() + kMargin; }

void Culprits::ask(const cycle::Event& event) { asked_.push_back({event, bus_.cycles()}); }

void Culprits::watch(const cycle::Snapshot& now) {
  for (Asked& a : asked_) ++a.steps;
  const bool whole = now.expected != 0 && now.working_counter == now.expected &&
                     now.al_states == static_cast<std::uint16_t>(AlState::Op);
  if (!asked_.empty() || !whole) return;
  stale_before_.resize(bus_.stations().size());
  devices::StationHealth health;
  for (std::size_t i = 0; i < stale_before_.size(); ++i)
    if (bus_.health(i, health)) stale_before_[i] = health.stale_cycles;
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
  devices::StationHealth health;
  for (std::size_t i = 0; i < bus_.stations().size(); ++i) {
    if (!bus_.health(i, health)) continue;
    const bool stale = health.stale_cycles > (i < stale_before_.size() ? stale_before_[i] : 0);
    const bool asked = health.al_cycle != 0 && health.al_cycle + turn() + kMargin >= bus_.cycles();
    const bool left = asked && health.al_status != static_cast<std::uint16_t>(AlState::Op);
    if ((!stale && !left) || ++count > kMostNamed) continue;
    const devices::StationRecord& station = bus_.stations()[i];
    known.where += (known.where.empty() ? "" : ", ") + station.where;
    if (left) known.what += words_of(station, health);
  }
  if (count > kMostNamed) known.where += fmt::format(" and {} more", count - kMostNamed);
  return known;
}

}  // namespace gantry::stations
