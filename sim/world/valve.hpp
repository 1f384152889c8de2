// The dispensing valve in continuous time: it follows its command after a lag of its own, which need not be a whole
// number of cycles.
//   valve.command(open, t);   // at a sync
//   while (auto edge = valve.next_edge(until)) ...   // physical edges up to `until`, in order
#pragma once
#include <deque>
#include <optional>

#include "core/clock.hpp"

namespace gantry::sim {

class Valve {
 public:
  struct Edge {
    bool open = false;
    Time at{};
  };

  Valve(Time open_lag, Time close_lag) : open_lag_(open_lag), close_lag_(close_lag) {}

  /// A command that ends before the valve has moved leaves it where it is.
  void command(bool open, Time at) noexcept {
    if (open == commanded_) return;
    commanded_ = open;
    const Edge edge{open, at + (open ? open_lag_ : close_lag_)};
    if (!waiting_.empty() && edge.at <= waiting_.back().at)
      waiting_.pop_back();  // the opposite edge that waits would come later than this one: the plunger never moves
    else
      waiting_.push_back(edge);
  }

  /// The next physical edge at or before `until`; none: nullopt.
  std::optional<Edge> next_edge(Time until) noexcept {
    if (waiting_.empty() || waiting_.front().at > until) return std::nullopt;
    const Edge edge = waiting_.front();
    waiting_.pop_front();
    open_ = edge.open;
    return edge;
  }

  [[nodiscard]] bool is_open() const noexcept { return open_; }
  [[nodiscard]] bool commanded() const noexcept { return commanded_; }

 private:
  Time open_lag_, close_lag_;
  bool commanded_ = false, open_ = false;
  std::deque<Edge> waiting_;  ///< in order; alternating
};

}  // namespace gantry::sim
