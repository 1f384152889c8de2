#include "sim/world/deposit_speed.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::sim {
namespace {

constexpr std::uint32_t kWindow = 5;  // syncs: one alone shows the motors' counts
constexpr double kSteady = 0.05;

/// Sums over all shots.
struct Sums {
  double least_mm_s = 1e9, most_mm_s = 0;
  double steady_mm = 0, seen_mm = 0;
};

/// Of chords [first, last) between the points of a path: length and how long it took.
void see(const Shot& shot, std::size_t first, std::size_t last, double sync_s, double asked_mm_s, Sums& sums) {
  std::size_t end = first;
  double mm = 0;
  std::uint32_t syncs = 0;
  for (std::size_t begin = first; begin < last; ++begin) {
    for (; end < last && syncs < kWindow; ++end) {
      mm += norm(shot.path[end + 1] - shot.path[end]);
      syncs += shot.since[end + 1] - shot.since[end];
    }
    const double own_mm = norm(shot.path[begin + 1] - shot.path[begin]);
    if (syncs == 0 || (syncs < kWindow && begin > first)) break;
    const double v = mm / (syncs * sync_s);
    sums.least_mm_s = std::min(sums.least_mm_s, v);
    sums.most_mm_s = std::max(sums.most_mm_s, v);
    sums.seen_mm += own_mm;
    if (std::abs(v - asked_mm_s) <= kSteady * asked_mm_s) sums.steady_mm += own_mm;
    mm -= own_mm;
    syncs -= shot.since[begin + 1] - shot.since[begin];
  }
}

}  // namespace

std::optional<DepositSpeed> speed_of(std::span<const Shot* const> shots, double asked_mm_s, double sync_s) {
  Sums sums;
  double open_s = 0, length_mm = 0;
  for (const Shot* shot : shots) {
    for (std::size_t i = 1; i < shot->path.size(); ++i) length_mm += norm(shot->path[i] - shot->path[i - 1]);
    open_s += seconds(shot->closed - shot->opened);
    // The first and the last point are those of the valve's edges, between two syncs.
    if (shot->path.size() >= 4 && shot->since.size() == shot->path.size())
      see(*shot, 1, shot->path.size() - 2, sync_s, asked_mm_s, sums);
  }
  if (!(open_s > 0) || !(length_mm > 0) || !(asked_mm_s > 0)) return std::nullopt;
  DepositSpeed out{.asked_mm_s = asked_mm_s, .volume_per_length = open_s * asked_mm_s / length_mm};
  if (sums.seen_mm > 0) {
    out.least_mm_s = sums.least_mm_s, out.most_mm_s = sums.most_mm_s;
    out.within_5_percent = sums.steady_mm / sums.seen_mm;
  } else {
    out.least_mm_s = out.most_mm_s = length_mm / open_s;
    out.within_5_percent = std::abs(out.most_mm_s - asked_mm_s) <= kSteady * asked_mm_s ? 1 : 0;
  }
  return out;
}

}  // namespace gantry::sim
