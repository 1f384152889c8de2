#include "motion/path/lead.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr std::uint16_t kLeadCells = 4;

using Bezier = std::array<AxisVec, 4>;

/// Coefficients of 1, w, w^2, w^3 of one axis, w in [0, 1].
using Cubic = std::array<double, 4>;

/// The cubic from w = 1 to w = 0 as Bezier points.
void take_axis(const Cubic& c, std::size_t axis, Bezier& bezier) {
  bezier[3][axis] = c[0];
  bezier[2][axis] = c[0] + c[1] / 3;
  bezier[1][axis] = c[0] + (2 * c[1] + c[2]) / 3;
  bezier[0][axis] = c[0] + c[1] + c[2] + c[3];
}

/// Both parts of what leads to `at`.
struct Parts {
  Bezier straight{}, bent{};
};

Parts parts_of(const CurveJet& at, double length_mm, double b, const Lift& lift) {
  const double rest = length_mm - b;
  const double up = lift.mm / (length_mm * length_mm * length_mm);
  Parts out;
  for (std::size_t i = 0; i < kMaxAxes; ++i) {
    const double q = at.q[i], d1 = at.d1[i], d2 = at.d2[i], z = i == lift.axis ? up : 0;
    take_axis({q, -d1 * b, d2 * b * b / 2, -d2 * b * b / 6 + z * b * b * b}, i, out.bent);
    take_axis({q - d1 * b + d2 * b * b / 3 + z * b * b * b, (-d1 + d2 * b / 2) * rest + z * 3 * b * b * rest,
               z * 3 * b * rest * rest, z * rest * rest * rest},
              i, out.straight);
  }
  return out;
}

}  // namespace

std::vector<Curve> lead_in(const Measure& measure, const CurveJet& at, double length_mm, double bent_mm,
                           const Lift& lift) {
  const Parts parts = parts_of(at, length_mm, bent_mm, lift);
  std::vector<Curve> out;
  if (bent_mm < length_mm && lift.mm == 0) out.push_back(straight_curve(measure, parts.straight[0], parts.straight[3]));
  if (bent_mm < length_mm && lift.mm != 0) append_curve(measure, parts.straight, kLeadCells, out);
  if (bent_mm > 0) append_curve(measure, parts.bent, kLeadCells, out);
  return out;
}

std::vector<Curve> lead_out(const Measure& measure, const CurveJet& at, double length_mm, double bent_mm) {
  CurveJet back = at;
  for (double& x : back.d1) x = -x;
  Parts parts = parts_of(back, length_mm, bent_mm, {});
  std::reverse(parts.bent.begin(), parts.bent.end());
  std::vector<Curve> out;
  if (bent_mm > 0) append_curve(measure, parts.bent, kLeadCells, out);
  if (bent_mm < length_mm) out.push_back(straight_curve(measure, parts.straight[3], parts.straight[0]));
  return out;
}

double bend_of(const Measure& measure, const CurveJet& at) {
  constexpr double kLeastRate = 0.02;  // rad/mm
  double bend = along(measure, at.d2);
  for (std::size_t i = 0; i < measure.axes; ++i)
    if (!measure.along[i]) bend = std::max(bend, std::abs(at.d2[i]) / std::max(std::abs(at.d1[i]), kLeastRate));
  return bend;
}

double bent_over_mm(double bend, double radii, double length_mm) {
  return bend * length_mm <= radii ? length_mm : radii / bend;
}

}  // namespace gantry::motion
