#include "app/job/nearest.hpp"

#include <cmath>
#include <fmt/format.h>

namespace gantry::job {

std::string to_text(const std::optional<Nearest>& nearest) {
  if (!nearest || !std::isfinite(nearest->distance_mm)) return "no such pair";
  const Nearest& n = *nearest;
  const Vec3& m = n.machine_mm;
  std::string at = fmt::format("{:.2f}, {:.2f}, {:.2f}", m.x, m.y, m.z);
  if (n.board_mm)
    at = fmt::format("({:.2f}, {:.2f}, {:.2f}) mm [machine {}]", n.board_mm->x, n.board_mm->y, n.board_mm->z, at);
  else
    at = fmt::format("({}) mm", at);
  return fmt::format("{:.3f} mm, {} and {}, {}{}, at {}", n.distance_mm, n.head, n.standing, n.motion,
                     n.where.empty() ? "" : fmt::format(" ({})", n.where), at);
}

}  // namespace gantry::job
