#include "app/stations/active_faults.hpp"

#include <algorithm>

#include "app/cycle/interlocks.hpp"
#include "config/inputs.hpp"

namespace gantry::stations {
namespace {

bool holds(const std::vector<Error>& list, Fault fault) {
  return std::any_of(list.begin(), list.end(), [&](const Error& e) { return e.fault == fault; });
}

}  // namespace

void ActiveFaults::came(const Error& words) {
  if (!holds(since_, words.fault)) since_.push_back(words);
}

void ActiveFaults::see(const cycle::Snapshot& s) {
  if (s.latched == latched_) return;
  // Another one is latched where a reset has found the first gone, or where it was the consequence of the second.
  std::erase_if(since_, [&](const Error& e) { return e.fault != s.latched; });
  latched_ = s.latched;
}

std::vector<Error> ActiveFaults::list(const config::Machine& machine, const cycle::Snapshot& s) const {
  if (s.latched == Fault::None) return {};
  std::vector<Error> active = since_;
  const auto add = [&](Fault fault) {
    if (!holds(active, fault)) active.push_back({fault, std::string(info(fault).text), ""});
  };
  add(s.latched);
  const auto is_low = [&](config::Input input) { return config::is_low(machine, s.inputs, input); };
  for (const cycle::Interlock& lock : cycle::kInterlocks) {
    if (is_low(lock.input) && (lock.in_setup || !is_low(config::Input::Mode))) add(lock.open);
    for (Error& e : active)
      if (e.fault == lock.open && !is_low(lock.input)) e.message += " - not any more";
  }
  std::stable_partition(active.begin(), active.end(), [&](const Error& e) { return e.fault == s.latched; });
  return active;
}

}  // namespace gantry::stations
