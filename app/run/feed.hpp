// The sole reader of what the loop says. Everyone else (recorder, publisher, runner, screen) hears it from here, on the
// run thread.
//   Feed feed(channels);   feed.listen([&](const Snapshot& s) {...}, [&](const Event& e) {...});   feed.drain();
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "app/cycle/channels.hpp"

namespace gantry::run {

class Feed {
 public:
  using OnSnapshot = std::function<void(const cycle::Snapshot&)>;
  using OnEvent = std::function<void(const cycle::Event&)>;

  explicit Feed(cycle::Channels& channels) : channels_(channels) {}

  /// Listeners live as long as the feed. They are called in the order in which they came.
  void listen(OnSnapshot on_snapshot, OnEvent on_event);

  /// Hands on all that waits, snapshots first. An event may be of a later cycle than latest(): who needs both waits for
  /// latest().cycle to come up.
  void drain();

  /// The newest snapshot; all zero before the first.
  [[nodiscard]] const cycle::Snapshot& latest() const { return latest_; }
  /// mm/s^2 along the path, over the last cycle; 0 where a block begins.
  [[nodiscard]] double path_acceleration() const { return path_acceleration_; }
  /// When the valve was last told to be open, on the clock of the snapshots; nothing: never since this bus is up.
  [[nodiscard]] std::optional<std::int64_t> valve_open_ns() const { return valve_open_ns_; }

 private:
  cycle::Channels& channels_;
  std::vector<OnSnapshot> on_snapshot_;
  std::vector<OnEvent> on_event_;
  cycle::Snapshot latest_{};
  double path_acceleration_ = 0;
  std::optional<std::int64_t> valve_open_ns_;
};

}  // namespace gantry::run
