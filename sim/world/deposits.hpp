// What came out of the valve, judged against what the recipe wants: by geometry alone, never by the controller's word.
//   auto deposits = judge(plan, intervals);   write_csv(deposits, "deposits.csv");
#pragma once
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "sim/world/board.hpp"
#include "sim/world/world_access.hpp"

namespace gantry::sim {

/// One time that the valve was open: where the needle was, in the board's frame (z: height over the true surface).
/// First and last point are those of the physical edges, between two syncs; the others those of syncs.
struct Shot {
  Time opened{}, closed{};  ///< on the machine's clock
  std::uint64_t opened_cycle = 0, closed_cycle = 0;
  std::vector<Vec3> path;
  std::vector<std::uint32_t>
      since;  ///< of each point: cycles since it was opened; where the needle stands none is kept
};

/// Each shot, in order, takes the nearest feature that no shot before it has taken, when it lies within `kMatch_mm` of
/// it; a second shot on the same feature, and one that lies on none, has no id. A shot that begins where a bead has
/// ended short, and follows it, is a part of that bead's deposit.
/// `purge_at`: where the needle is to be purged, board frame; a standing shot that is nearer to it than to any feature
/// belongs there. `machine`: whose cycle and axes the speeds of beads are judged by; without one its cycle is 1 ms, and
/// no speed is judged by what axes can do.
std::vector<Deposit> judge(const BoardPlan& plan, std::span<const std::shared_ptr<const Shot>> shots,
                           std::optional<Vec2> purge_at = {}, const config::Machine* machine = nullptr);

inline constexpr double kMatch_mm = 3;
/// A shot that moves less than this is a dot by its own geometry.
inline constexpr double kDotExtent_mm = 0.2;

/// Index of the feature that a needle at `at` would begin; nothing within kMatch_mm: -1.
int feature_begun(const BoardPlan& plan, const Starts& starts, Vec2 at);

/// id, kind, opened_cycle, closed_cycle, error_mm (empty: on no feature), gap_mm, nominal_mm, board_mm ("x y z;x y z"),
/// joins_mm; of beads also speed_min_mm_s, speed_max_mm_s, within_5_percent, volume_per_length; open_ms.
Result<void> write_csv(std::span<const Deposit> deposits, const std::string& path);

/// Largest distance between a dispensed path and a polyline: of every point of the path to the polyline, of every
/// corner of the polyline to the path, and of the two ends; seen from above.
double path_error(std::span<const Vec3> path, std::span<const Vec3> nominal);

/// Of the heights of a path over a polyline, that one's difference from the gap which differs most; 0 where none does.
double gap_error(std::span<const Vec3> path, std::span<const Vec3> nominal, double gap_mm);

}  // namespace gantry::sim
