#include "app/run/feed.hpp"

#include <utility>

#include "config/machine.hpp"

namespace gantry::run {

void Feed::listen(OnSnapshot on_snapshot, OnEvent on_event) {
  if (on_snapshot) on_snapshot_.push_back(std::move(on_snapshot));
  if (on_event) on_event_.push_back(std::move(on_event));
}

void Feed::drain() {
  for (cycle::Snapshot s; channels_.snapshots.pop(s);) {
    const double passed_s = static_cast<double>(s.time_ns - latest_.time_ns) * 1e-9;
    const bool goes_on = s.block != 0 && s.block == latest_.block && passed_s > 0;
    path_acceleration_ = goes_on ? (s.path_speed - latest_.path_speed) / passed_s : 0;
    latest_ = s;
    if ((s.outputs & config::bit(config::Output::Valve)) != 0) valve_open_ns_ = s.time_ns;
    for (const auto& listener : on_snapshot_) listener(s);
  }
  for (cycle::Event e; channels_.events.pop(e);)
    for (const auto& listener : on_event_) listener(e);
}

}  // namespace gantry::run
