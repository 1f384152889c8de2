#include "vision/fit_offset.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>
#include <numbers>

namespace gantry::vision {
namespace {

constexpr double kSamePosition_mm = 1e-3;

/// How far the nominal marks lie from the first of them, at most.
double spread(std::span<const MarkPair> marks) {
  double most = 0;
  for (const MarkPair& m : marks) most = std::max(most, norm(m.nominal_mm - marks.front().nominal_mm));
  return most;
}

std::string list(const std::vector<MarkResidual>& residuals) {
  std::string out;
  for (const MarkResidual& r : residuals)
    out += fmt::format("{}{} {:.3f} mm", out.empty() ? "" : ", ", r.name, norm(r.residual_mm));
  return out;
}

/// Which single mark, left out, makes the others agree; empty when none does, or when it could be several.
std::string suspect(std::span<const MarkPair> marks, double max_residual_mm) {
  if (marks.size() < 4) return "three marks or fewer cannot tell which one is wrong";
  std::vector<std::string> blamed;
  for (std::size_t out = 0; out < marks.size(); ++out) {
    std::vector<MarkPair> others;
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (i != out) others.push_back(marks[i]);
    if (spread(others) > kSamePosition_mm && fit_rigid(others).max_mm <= max_residual_mm)
      blamed.push_back(marks[out].name);
  }
  if (blamed.size() == 1) return fmt::format("without {} the others agree: look at that mark", blamed.front());
  return blamed.empty() ? "no single mark explains it" : "it cannot be told which one is wrong";
}

}  // namespace

OffsetFit fit_rigid(std::span<const MarkPair> marks) {
  OffsetFit fit;
  const auto n = static_cast<double>(marks.size());
  Vec2 nominal_mean, found_mean;
  for (const MarkPair& m : marks) {
    nominal_mean = nominal_mean + m.nominal_mm * (1 / n);
    found_mean = found_mean + m.found_mm * (1 / n);
  }
  // In the plane the best rotation of the centred points is the angle of sum(nominal* . found) as complex numbers.
  double along = 0, across = 0;
  for (const MarkPair& m : marks) {
    const Vec2 a = m.nominal_mm - nominal_mean, b = m.found_mm - found_mean;
    along += dot(a, b);
    across += a.x * b.y - a.y * b.x;
  }
  fit.rotation_rad = std::atan2(across, along);
  fit.shift_mm = found_mean - rotated(nominal_mean, fit.rotation_rad);
  fit.redundancy = 2 * static_cast<int>(marks.size()) - 3;
  double square = 0;
  for (const MarkPair& m : marks) {
    const Vec2 r = m.found_mm - (rotated(m.nominal_mm, fit.rotation_rad) + fit.shift_mm);
    fit.residuals.push_back({m.name, r});
    square += dot(r, r);
    fit.max_mm = std::max(fit.max_mm, norm(r));
  }
  fit.rms_mm = std::sqrt(square / n);
  return fit;
}

Result<OffsetFit> fit_offset(std::span<const MarkPair> marks, const FitRules& rules) {
  if (marks.size() < 2)
    return fail(Fault::MarksTooFew,
                fmt::format("{} mark{} found; a work offset needs two", marks.size(), marks.size() == 1 ? "" : "s"));
  for (const MarkPair& m : marks)
    if (!std::isfinite(m.nominal_mm.x + m.nominal_mm.y + m.found_mm.x + m.found_mm.y))
      return fail(Fault::ResidualTooLarge, fmt::format("the position of mark {} is not a number", m.name));
  if (spread(marks) <= kSamePosition_mm)
    return fail(Fault::MarksTooFew, "all marks stand at one position; the board's rotation cannot be found");
  OffsetFit fit = fit_rigid(marks);
  if (!(fit.max_mm <= rules.max_residual_mm))
    return fail(Fault::ResidualTooLarge,
                fmt::format("the marks disagree by more than {:.3f} mm: {}; {}", rules.max_residual_mm,
                            list(fit.residuals), suspect(marks, rules.max_residual_mm)));
  if (norm(fit.shift_mm) > rules.max_shift_mm)
    return fail(
        Fault::ResidualTooLarge,
        fmt::format(
            "the board would lie {:.3f} mm off its nominal position, more than the {:.3f} mm of mark_rules: max_shift",
            norm(fit.shift_mm), rules.max_shift_mm));
  if (std::abs(fit.rotation_rad) > rules.max_rotation_rad) {
    constexpr double kDegree = 180 / std::numbers::pi;
    return fail(
        Fault::ResidualTooLarge,
        fmt::format("the board would be turned by {:.3f} deg, more than the {:.3f} deg of mark_rules: max_rotation",
                    fit.rotation_rad * kDegree, rules.max_rotation_rad * kDegree));
  }
  return fit;
}

}  // namespace gantry::vision
