// What is played as a polyline, for proofs: its points lie on the path, and the path leaves it by at most kChord_mm.
//   certify(scene, chords(bead.segments), rules, kChord_mm)
// Off the RT side.
#pragma once
#include <span>
#include <vector>

#include "motion/types.hpp"

namespace gantry::motion {

/// mm over all axes together, a rad counted as a mm.
inline constexpr double kChord_mm = 0.005;

/// From the first segment's start to the last one's end. A cubic q(u) is off its chord by at most max |q''(u)| du^2 /
/// 8, and q'' is linear in u: the greater of its ends counts.
std::vector<AxisVec> chords(std::span<const Segment> segments);

/// How far what is played may be off its chords: 0 where all of it is straight.
double off_chords_mm(std::span<const Segment> segments);

}  // namespace gantry::motion
