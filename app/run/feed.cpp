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
    latest_ = s;
    if ((s.outputs & config::bit(config::Output::Valve)) != 0) valve_open_ns_ = s.time_ns;
    for (const auto& listener : on_snapshot_) listener(s);
  }
  for (cycle::Event e; channels_.events.pop(e);)
    for (const auto& listener : on_event_) listener(e);
}

}  // namespace gantry::run
