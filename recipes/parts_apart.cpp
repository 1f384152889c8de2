#include "recipes/parts_apart.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <vector>

namespace gantry::recipes {
namespace {

constexpr double kFlush_mm = 0.01;

bool wholly_inside(const Part& inner, const Part& outer) {
  if (inner.size.z > outer.size.z + kFlush_mm) return false;
  for (const Vec2 corner : {Vec2{1, 1}, Vec2{-1, 1}, Vec2{1, -1}, Vec2{-1, -1}}) {
    const Vec2 half{corner.x * inner.size.x / 2, corner.y * inner.size.y / 2};
    const Vec2 p = rotated(inner.at + rotated(half, inner.rotation) - outer.at, -outer.rotation);
    if (std::abs(p.x) > outer.size.x / 2 + kFlush_mm || std::abs(p.y) > outer.size.y / 2 + kFlush_mm) return false;
  }
  return true;
}

double half_diagonal(const Part& part) { return norm(Vec2{part.size.x, part.size.y}) / 2; }

}  // namespace

void check_parts_apart(const Recipe& recipe, config::Mistakes& mistakes) {
  std::vector<const Part*> parts;  // in the order of the file
  for (const Part& part : recipe.parts)
    if (!part.fixture) parts.push_back(&part);
  // By where they begin along X: what can hold a part begins before its middle, and ends behind it.
  std::vector<const Part*> by_x = parts;
  const auto low = [](const Part* p) { return p->at.x - half_diagonal(*p); };
  std::sort(by_x.begin(), by_x.end(), [&](const Part* a, const Part* b) { return low(a) < low(b); });
  for (const Part* inner : parts)
    for (const Part* outer : by_x) {
      if (low(outer) > inner->at.x) break;
      if (outer == inner || outer->at.x + half_diagonal(*outer) < inner->at.x || !wholly_inside(*inner, *outer))
        continue;
      if (outer > inner && wholly_inside(*outer, *inner)) continue;  // the same; the later one is told
      mistakes.add(Fault::Inconsistent,
                   fmt::format("part '{}' is inside '{}', where it changes nothing; correct the 'at' or 'size' of one "
                               "of them, or leave it out",
                               inner->name, outer->name),
                   inner->location);
      break;
    }
}

}  // namespace gantry::recipes
