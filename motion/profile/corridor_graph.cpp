// The graph of touches and its shortest path.
#include <algorithm>

#include "motion/profile/brake.hpp"
#include "motion/profile/corridor.hpp"

namespace gantry::motion {
namespace {

constexpr int kGrid = 32;         // intervals over the range of accelerations
constexpr double kFinest = 1e-9;  // of that range: to which touches are refined
constexpr double kJump = 0.25;    // relative change of a leg's duration between neighbours that tells a jump
constexpr int kHalvings = 12;     // towards it
constexpr int kMostLegs = 2000;   // between touches

constexpr Via::Kind kind_of(bool upper) noexcept { return upper ? Via::Kind::Upper : Via::Kind::Lower; }

}  // namespace

void Corridor::add(const Via& via) noexcept {
  if (!(via.share >= 0 && via.share <= 1) || nodes_ == kMostNodes) return;
  Node& n = node(nodes_++) = Node{};
  n.via = via;
  n.since = leg(from_, at(via)), n.until = leg(at(via), to_);
}

/// A grid, and where a leg's duration jumps or ends between two of its points, both sides of that.
void Corridor::add_grid(bool upper) noexcept {
  for (int i = 0; i <= kGrid; ++i) add({kind_of(upper), static_cast<double>(i) / kGrid});
  const int end = nodes_;
  for (int i = end - kGrid; i < end; ++i)
    for (const bool since : {true, false}) {
      Node low = node(i - 1), high = node(i);
      const auto apart = [since](const Node& x, const Node& y) {
        const double a = since ? x.since : x.until, b = since ? y.since : y.until;
        return a == b ? 0 : std::abs(a - b) / std::min(a, b);  // one never: infinite
      };
      for (int k = 0; k < kHalvings && apart(low, high) > kJump; ++k) {
        Node middle;
        middle.via = {kind_of(upper), (low.via.share + high.via.share) / 2};
        (since ? middle.since : middle.until) = since ? leg(from_, at(middle.via)) : leg(at(middle.via), to_);
        (apart(low, middle) > apart(middle, high) ? high : low) = middle;
      }
      if (apart(low, high) > kJump) add(low.via), add(high.via);
    }
}

/// What hardest braking leads to, from limit to limit: where there is little room, only touches close to these do.
void Corridor::add_bounces(bool forward) noexcept {
  for (bool upper : {true, false}) {
    State x = forward ? from_ : to_;
    for (int bounce = 0; bounce < 3 && exists(upper); ++bounce, upper = !upper) {
      const Brake b =
          forward ? (upper ? brake_up(x, b_) : brake_down(x, b_)) : (upper ? came_up(x, b_) : came_down(x, b_));
      if (!b.rises) break;
      const double share = b.at_top / most(upper);
      for (const double d : {-0.02, -0.004, -0.001, -0.0002, 0.0, 0.0002, 0.001, 0.004, 0.02})
        add({kind_of(upper), share + d});
      x = at({kind_of(upper), std::min(share, 1.0)});
    }
  }
}

void Corridor::add_contacts() noexcept {
  for (const bool upper : {true, false})
    if (exists(upper)) add_grid(upper);
  add_bounces(true), add_bounces(false);
}

/// Dijkstra: the shortest path from the start to every node that can be on one to the target of less than `enough`.
/// Returns the last node before the target on the shortest path; negative: there is none.
int Corridor::explore(double enough) noexcept {
  int last = -1, legs = 0;
  for (int round = 0; round < nodes_; ++round) {
    int near = -1;
    for (int i = 0; i < nodes_; ++i)
      if (!node(i).done && (near < 0 || node(i).since < node(near).since)) near = i;
    Node& n = node(near);
    if (n.since >= enough) break;
    n.done = true;
    if (n.since + n.until < enough) enough = n.since + n.until, last = near;
    if (n.touches == static_cast<int>(Route::kMostVias)) continue;
    for (int i = 0; i < nodes_ && legs < kMostLegs; ++i) {
      Node& next = node(i);
      if (next.done || n.since >= next.since) continue;
      ++legs;
      const double t = n.since + leg(at(n.via), at(next.via));
      if (t < next.since) next.since = t, next.before = near, next.touches = n.touches + 1;
    }
  }
  return last;
}

Route Corridor::route_to(int last) noexcept {
  Route route;
  route.duration_s = node(last).since + node(last).until;
  for (int i = last; i >= 0; i = node(i).before) route.vias.push_back(node(i).via);
  std::reverse(route.vias.begin(), route.vias.end());
  return route;
}

Route Corridor::shortest() noexcept {
  Route best;
  best.duration_s = leg(from_, to_);
  if (best) return best;
  add_contacts();
  const int last = explore(kNever);
  if (last < 0) return best;
  best = route_to(last);
  refine(best, 0);
  return best;
}

/// Compass search: steps up and down in each share, halved where none helps.
void Corridor::refine(Route& route, double least) const noexcept {
  constexpr int kMostTries = 400;
  int tries = 0;
  for (double step = 1.0 / kGrid; step > kFinest && tries < kMostTries; step /= 2)
    for (bool better = true; better && tries < kMostTries;) {
      better = false;
      for (std::size_t i = 0; i < route.vias.size(); ++i)
        for (const double by : {-step, step}) {
          Route other = route;
          other.vias[i].share = std::clamp(route.vias[i].share + by, 0.0, 1.0);
          if (least > 0)
            other = timed(other, least);
          else
            other.duration_s = time(other);
          ++tries;
          if (other.duration_s < route.duration_s) route = other, better = true;
        }
    }
}

}  // namespace gantry::motion
