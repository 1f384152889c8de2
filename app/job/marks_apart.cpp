#include "app/job/marks_apart.hpp"

#include <cmath>
#include <fmt/format.h>

#include "app/job/settle.hpp"
#include "vision/gates.hpp"

namespace gantry::job {
namespace {

/// Whether `other` passes for `wanted` where its picture is all there.
bool look_alike(const recipes::MarkDef& wanted, const recipes::MarkDef& other) {
  return other.bright == wanted.bright &&
         std::abs(other.diameter / wanted.diameter - 1) <= vision::FindRules{}.max_scale_error;
}

/// Over `wanted`, in the middle of the picture.
bool seen_beside(const recipes::MarkDef& wanted, const recipes::MarkDef& other, const config::CameraConfig& camera) {
  const Vec2 off = other.at - wanted.at;
  const auto whole = [&](double off_mm, int pixels) {
    return std::abs(off_mm) + other.diameter / 2 <= 0.5 * camera.mm_per_px * pixels;
  };
  return norm(off) <= camera.search_mm && whole(off.x, camera.width_px) && whole(off.y, camera.height_px);
}

}  // namespace

Result<void> marks_apart(const recipes::Recipe& recipe, const config::Machine& machine) {
  const config::CameraConfig& camera = machine.camera;
  for (std::size_t second = 1; second < recipe.marks.size(); ++second)
    for (std::size_t first = 0; first < second; ++first) {
      const recipes::MarkDef &a = recipe.marks[first], &b = recipe.marks[second];
      const bool mistaken =
          (look_alike(a, b) && seen_beside(a, b, camera)) || (look_alike(b, a) && seen_beside(b, a, camera));
      if (!mistaken) continue;
      return fail(Fault::Inconsistent,
                  fmt::format("mark '{}' looks like mark '{}' and is {:.6g} mm from it, and the camera looks for each "
                              "within {:.6g} mm, where it finds both; put them farther apart, give one of them another "
                              "diameter, or write a smaller `search` under `camera` of the machine",
                              b.name, a.name, norm(b.at - a.at), camera.search_mm),
                  at_line(recipe, b.location));
    }
  return {};
}

}  // namespace gantry::job
