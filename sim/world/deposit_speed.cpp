#include "sim/world/deposit_speed.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace gantry::sim {
namespace {

constexpr std::uint32_t kWindow = 5;  // syncs: one alone shows the motors' counts
constexpr double kSteady = 0.05;

constexpr double kBegun_mm = 0.05;  // nearer to its start it may stand: `start_dwell`

/// Speeds over a window that goes along a shot from point `from` on, sync by sync: visit(first, last, v) of the chords
/// [first, last) in it. The first and the last point of a shot are those of the valve's edges, between two syncs.
template <class Visit>
void along(const Shot& shot, std::size_t from, std::uint32_t window, double sync_s, Visit&& visit) {
  if (shot.path.size() < from + 3 || shot.since.size() != shot.path.size()) return;
  const std::size_t last = shot.path.size() - 2;
  std::size_t end = from;
  double mm = 0;
  std::uint32_t syncs = 0;
  for (std::size_t begin = from; begin < last; ++begin) {
    for (; end < last && syncs < window; ++end) {
      mm += norm(shot.path[end + 1] - shot.path[end]);
      syncs += shot.since[end + 1] - shot.since[end];
    }
    if (syncs == 0 || (syncs < window && begin > from)) break;
    visit(begin, end, mm / (syncs * sync_s));
    mm -= norm(shot.path[begin + 1] - shot.path[begin]);
    syncs -= shot.since[begin + 1] - shot.since[begin];
  }
}

/// Sums over all shots.
struct Sums {
  double least_mm_s = 1e9, most_mm_s = 0;
  double steady_mm = 0, seen_mm = 0;
};

void see(const Shot& shot, double sync_s, double asked_mm_s, Sums& sums) {
  along(shot, 1, kWindow, sync_s, [&](std::size_t first, std::size_t, double v) {
    const double own_mm = norm(shot.path[first + 1] - shot.path[first]);
    sums.least_mm_s = std::min(sums.least_mm_s, v);
    sums.most_mm_s = std::max(sums.most_mm_s, v);
    sums.seen_mm += own_mm;
    if (std::abs(v - asked_mm_s) <= kSteady * asked_mm_s) sums.steady_mm += own_mm;
  });
}

double stood_s(const Shot& shot, double sync_s) {
  std::size_t n = 0;
  const auto off_mm = [&](Vec3 p) { return std::hypot(p.x - shot.path[0].x, p.y - shot.path[0].y); };
  while (n + 1 < shot.path.size() && off_mm(shot.path[n]) <= kSetOut_mm) ++n;
  return n < shot.since.size() ? shot.since[n] * sync_s : 0;
}

void judge(const Shot& shot, SteadySpeed& judged) {
  if (shot.since.size() != shot.path.size()) return;
  std::size_t from = 1;
  while (from < shot.path.size() && norm(shot.path[from] - shot.path.front()) < kBegun_mm) ++from;
  for (std::size_t i = from; i + 2 < shot.path.size(); ++i)
    judged.add(norm(shot.path[i + 1] - shot.path[i]), shot.since[i + 1] - shot.since[i]);
  judged.end_stretch();
}

}  // namespace

std::optional<DepositSpeed> speed_of(std::span<const Shot* const> shots, AskedSpeed asked, double sync_s) {
  if (!(asked.mm_s > 0)) return std::nullopt;
  Sums sums;
  SteadySpeed judged(asked, sync_s);
  double open_s = 0, length_mm = 0;
  for (const Shot* shot : shots) {
    for (std::size_t i = 1; i < shot->path.size(); ++i) length_mm += norm(shot->path[i] - shot->path[i - 1]);
    open_s += seconds(shot->closed - shot->opened);
    see(*shot, sync_s, asked.mm_s, sums);
    judge(*shot, judged);
  }
  if (!(open_s > 0) || !(length_mm > 0)) return std::nullopt;
  DepositSpeed out{.asked_mm_s = asked.mm_s,
                   .volume_per_length = open_s * asked.mm_s / length_mm,
                   .within_tolerance = judged.within(),
                   .held_mm_s = judged.held_mm_s(),
                   .sag = judged.sag(),
                   .stood_s = stood_s(*shots.front(), sync_s)};
  if (sums.seen_mm > 0) {
    out.least_mm_s = sums.least_mm_s, out.most_mm_s = sums.most_mm_s;
    out.within_5_percent = sums.steady_mm / sums.seen_mm;
  } else {
    out.least_mm_s = out.most_mm_s = length_mm / open_s;
    out.within_5_percent = std::abs(out.most_mm_s - asked.mm_s) <= kSteady * asked.mm_s ? 1 : 0;
  }
  return out;
}

}  // namespace gantry::sim
