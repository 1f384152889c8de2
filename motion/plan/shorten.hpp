// Makes a polyline of positions shorter as long as it stays clear: leaves corners out, pulls them in, cuts them.
//   shorten(points, clear);   // clear(a, b): may one go straight from a to b?
// The ends stay. Never longer than before; the same on every run.
#pragma once
#include <functional>
#include <vector>

#include "core/vec.hpp"

namespace gantry::motion {

using Clear = std::function<bool(Vec3, Vec3)>;

/// From each point straight to the last one that can be seen from there.
void leave_out(std::vector<Vec3>& points, const Clear& clear);
void shorten(std::vector<Vec3>& points, const Clear& clear);

}  // namespace gantry::motion
