// Travel as one motion: up, across and down, each the straight motion from rest to rest that it is alone, but across
// begins before up has ended, and down before across has.
//   if (auto spec = arch_over(points, z)) { spec->leave_mm = 1.5; Arch a = arch(limits, *spec); ... a.segments }
// Motions that go on at the same time move different axes, so that each axis keeps its limits as it does alone.
// Off the RT side.
#pragma once
#include <optional>
#include <span>
#include <vector>

#include "motion/types.hpp"

namespace gantry::motion {

struct ArchSpec {
  AxisVec from{}, to{};
  std::size_t up = 2;    ///< the axis that goes up; larger is higher
  double top = 0;        ///< its highest position, not below either end
  double leave_mm = 0;   ///< so far it goes up before anything else moves
  double arrive_mm = 0;  ///< from so far above the end on nothing else moves
};

struct Arch {
  /// Of kind Piece, from rest to rest in whole ticks. Where two motions overlap a piece is a cubic in time: its s is
  /// not arc length, but goes by evenly; its length is the path's.
  std::vector<Segment> segments;
  std::size_t up = 0, down = 0;  ///< how many of them, at the beginning and at the end, are straight up and down
};

/// What a polyline of straight motions (up, across, down; one of the vertical ones may be missing) is as an arch at the
/// height of the higher end of its motion across. Nothing where it has another shape.
[[nodiscard]] std::optional<ArchSpec> arch_over(std::span<const AxisVec> polyline, std::size_t up);

/// As early as the spec allows. Where the motion across is too short for both overlaps they share it.
[[nodiscard]] Arch arch(const Limits& limits, const ArchSpec& spec);

/// A straight run-up, from rest to the speed at its end, and at the same time down from so far above it: both end
/// together, what is longer begins first. The run-up takes whole ticks, and the result does. Empty: it leaves the axis
/// that goes down nothing for that.
[[nodiscard]] std::vector<Segment> fall_into(const Limits& limits, const Segment& run_up, std::size_t up,
                                             double fall_mm);

}  // namespace gantry::motion
