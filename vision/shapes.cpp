#include "vision/shapes.hpp"

namespace gantry::vision {
namespace {

Distance distance_to(const Disc& disc, Vec2 p) {
  const double r = norm(p);
  return {r - disc.diameter_px / 2, r > 1e-9 ? p * (1 / r) : Vec2{1, 0}};
}
double reach(const Disc& disc) { return disc.diameter_px / 2; }
double depth(const Disc& disc) { return disc.diameter_px / 2; }

}  // namespace

Distance distance(const Shape& shape, Vec2 from_centre) {
  return std::visit([&](const auto& s) { return distance_to(s, from_centre); }, shape);
}
double reach_px(const Shape& shape) {
  return std::visit([](const auto& s) { return reach(s); }, shape);
}
double depth_px(const Shape& shape) {
  return std::visit([](const auto& s) { return depth(s); }, shape);
}

}  // namespace gantry::vision
