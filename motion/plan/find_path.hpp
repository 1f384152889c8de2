// A path from here to there that meets nothing, for a job: straight when that is free, else over what stands between at
// the lowest Z that is free, else around it (search_path.hpp). Everything it returns is certified; the same query gives
// the same path on every run; where ways are known, so does the same question asked of a scene that differs a little.
//   Result<Path> path = find_path(scene, from, to, {.clearance_mm = 2, .approaches = {{"needle", "board", gap -
//   0.02}}});
// Where the margin must give way: at the ends of a motion a tool is near the surface by design. An allowed
// approach (sweep.hpp) names the pair and what it still keeps over the whole motion: needle over board `gap - 0.02`,
// probe on board `-travel`. Every other pair keeps the full clearance, at the ends too. A board that stands tilted is
// added as a box up to its highest corner; the allowed approach then covers its fall as well. Wet deposits are no
// bodies: who travels over them lifts first.
#pragma once
#include <vector>

#include "core/axis_vec.hpp"
#include "core/error.hpp"
#include "motion/plan/certificate.hpp"
#include "motion/plan/known_ways.hpp"
#include "motion/plan/scene.hpp"
#include "motion/plan/search_path.hpp"

namespace gantry::motion {

using PathRules = ClearanceRules;

struct Path {
  PathKind kind = PathKind::Standstill;
  std::vector<AxisVec> points;  ///< from, ..., to: straight motions of the axes, with a stop or a blend between them
  Certificate certificate;      ///< with the extra margin that was asked for
};

/// `extra_mm`: path deviation to be covered besides the clearance (of what is proved by chords).
/// Fault::OutOfReach when `to` is beyond an axis limit (named), Fault::Collision with both bodies, the point and what
/// was tried.
/// `measuring` as for certify(). `known`: where nothing straight or over is free, what was found then comes before a
/// search, and where none was found then there is none now.
Result<Path> find_path(const Scene& scene, const AxisVec& from, const AxisVec& to, const PathRules& rules,
                       double extra_mm = 0, const Measuring& measuring = {}, const KnownWays* known = nullptr);

}  // namespace gantry::motion
