#include "motion/plan/lift_over.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "motion/plan/certificate.hpp"

namespace gantry::motion {
namespace {

constexpr double kResolution_mm = 1e-3;

struct Across {
  AxisVec from{}, to{};
};

/// The motion across at height z, with the lift as high as the higher of both ends has it (a larger U is lower).
Across across_at(const Scene& scene, const AxisVec& from, const AxisVec& to, double z) {
  Across a{from, to};
  a.from[scene.z()] = a.to[scene.z()] = z;
  if (scene.has_lift()) a.from[scene.u()] = a.to[scene.u()] = std::min(from[scene.u()], to[scene.u()]);
  return a;
}

/// Height at which a pair that hits at `z` lets the motion across pass: the upper end of the interval it forbids (of a
/// body that turns, an upper end: what it may meet need not be one interval).
double climb(const Scene& scene, const AxisVec& from, const AxisVec& to, std::size_t head, std::size_t standing,
             double margin, double z) {
  const SceneBody &a = scene.head()[head], &b = scene.standing()[standing];
  const double bottom = a.solid.centre.z - a.half_box.z + scene.carried(a, across_at(scene, from, to, z).from).z;
  double hit = z, free = z + (b.solid.centre.z + b.half_box.z + margin - bottom) + kResolution_mm;
  while (free - hit > kResolution_mm) {
    const double middle = (free + hit) / 2;
    const Across across = across_at(scene, from, to, middle);
    (is_clear(scene, head, standing, across.from, across.to, margin) ? free : hit) = middle;
  }
  return free;
}

/// What a box test leaves over of the bodies from number `first` on, in their order.
void collect(const Scene& scene, const BodySweep& body, double margin, std::uint32_t first,
             std::vector<std::uint32_t>& near) {
  near.clear();
  const auto& nodes = scene.tree().nodes();
  for (std::size_t i = 0; i < nodes.size();) {
    const bool far = body.far(nodes[i].box, margin);
    if (!far && nodes[i].body != Tree::kInner && nodes[i].body >= first) near.push_back(nodes[i].body);
    i = far ? nodes[i].skip : i + 1;
  }
  std::sort(near.begin(), near.end());
}

}  // namespace

tl::expected<LiftOver, NoLiftOver> lift_over(const Scene& scene, const AxisVec& from, const AxisVec& to,
                                             const Margins& margins) {
  const std::size_t z_axis = scene.z();
  const double z_max = scene.axes()[z_axis].p_max;
  double z = std::max(from[z_axis], to[z_axis]);
  std::vector<std::uint32_t> near;
  for (bool climbed = true; climbed;) {
    climbed = false;
    for (std::size_t i = 0; i < scene.head().size(); ++i) {
      Across across = across_at(scene, from, to, z);
      BodySweep body(scene, i, across.from, across.to);
      const auto keeps = [&](std::uint32_t k, double margin) {
        return body.prove(k, margin) ||
               (body.left_open_mm() > kTurn_mm && is_clear(scene, i, k, across.from, across.to, margin));
      };
      collect(scene, body, margins.clearance_mm, 0, near);
      for (std::size_t n = 0; n < near.size(); ++n) {
        const std::uint32_t k = near[n];
        if (keeps(k, margins.clearance_mm)) continue;
        const double margin = margins.of(i, k);
        if (margin < margins.clearance_mm && keeps(k, margin)) continue;
        z = climb(scene, from, to, i, k, margin, z);
        if (z > z_max)
          return tl::unexpected(NoLiftOver{
              fmt::format("to lift {} over {} {} would have to go to {:.2f} mm; its limit is {:.2f} mm",
                          scene.head()[i].name, scene.standing()[k].name, scene.axes()[z_axis].name, z, z_max)});
        climbed = true;
        across = across_at(scene, from, to, z);
        body = BodySweep(scene, i, across.from, across.to);
        collect(scene, body, margins.clearance_mm, k + 1, near);
        n = static_cast<std::size_t>(-1);
      }
    }
  }

  const Across across = across_at(scene, from, to, z);
  LiftOver out{{from}, z};
  for (const AxisVec& next : {across.from, across.to, to})
    if (next != out.points.back()) out.points.push_back(next);
  // Rising further only lengthens the motions up and down, so what blocks them here blocks every lift-over.
  for (std::size_t i = 0; i + 1 < out.points.size(); ++i)
    if (const auto hit = first_hit(scene, out.points[i], out.points[i + 1], margins)) {
      const char* const leg = out.points[i] == across.from ? "across" : i == 0 ? "up" : "down";
      return tl::unexpected(
          NoLiftOver{fmt::format("lifted to {:.2f} mm, on the motion {} {}", z, leg, describe(scene, *hit))});
    }
  return out;
}

}  // namespace gantry::motion
