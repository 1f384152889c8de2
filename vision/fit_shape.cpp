#include "vision/fit_shape.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace gantry::vision {
namespace {

constexpr double kTukey = 4.685;        // 95 % efficiency on normal residuals (Huber 1981, 7.10)
constexpr double kMadToSigma = 1.4826;  // of the normal distribution
constexpr double kBlurMin = 0.25, kScaleMin = 0.7, kScaleMax = 1.4;
constexpr double kStepMax_px = 2.0, kStepScale = 0.04;
constexpr double kConverged_px = 2e-4;

enum Parameter { kX, kY, kScale, kBlur, kLevel, kContrast, kGradX, kGradY, kParameters };
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

struct Sample {
  double x = 0, y = 0, grey = 0;
};

std::vector<Sample> samples_near_edge(const Image& image, const MarkModel& model, const ShapeFit& start,
                                      const FitEffort& effort) {
  const double band = band_px(model, effort);
  const double reach = reach_px(model.shape) * start.scale + band + 1;
  const int s = effort.stride;
  const auto from = [&](double c) { return std::max(0, static_cast<int>(std::floor(c - reach)) / s * s); };
  const int x_end = std::min(image.width - 1, static_cast<int>(std::ceil(start.at_px.x + reach)));
  const int y_end = std::min(image.height - 1, static_cast<int>(std::ceil(start.at_px.y + reach)));
  std::vector<Sample> out;
  for (int y = from(start.at_px.y); y <= y_end; y += s)
    for (int x = from(start.at_px.x); x <= x_end; x += s) {
      const Vec2 q = Vec2{1.0 * x, 1.0 * y} - start.at_px;
      if (std::abs(distance(model.shape, q * (1 / start.scale)).value * start.scale) > band) continue;
      if (effort.leave_out[sector_of(q)]) continue;
      out.push_back({1.0 * x, 1.0 * y, 1.0 * image.at(x, y)});
    }
  return out;
}

double normal_cdf(double z) { return z > 6 ? 1.0 : z < -6 ? 0.0 : 0.5 * std::erfc(-z * std::numbers::sqrt2 / 2); }
double normal_pdf(double z) {
  return std::abs(z) > 6 ? 0.0 : std::exp(-0.5 * z * z) * std::numbers::inv_sqrtpi / std::numbers::sqrt2;
}

/// Derivatives of the model at one sample, and its value.
double linearise(const MarkModel& model, const ShapeFit& f, const Sample& sample, double grad_unit, Vector& j) {
  const Vec2 at{sample.x, sample.y};
  const Vec2 q = (at - f.at_px) * (1 / f.scale), r = at - f.start_px;
  const Distance d = distance(model.shape, q);
  const double z = -f.scale * d.value / f.blur_px;
  const double inside = normal_cdf(z), per_sdf = f.contrast * normal_pdf(z) / f.blur_px;  // -dI/dsdf
  j[kX] = per_sdf * d.gradient.x;
  j[kY] = per_sdf * d.gradient.y;
  j[kScale] = -per_sdf * (d.value - dot(d.gradient, q));
  j[kBlur] = -per_sdf * z;
  j[kLevel] = 1;
  j[kContrast] = inside;
  j[kGradX] = r.x * grad_unit;
  j[kGradY] = r.y * grad_unit;
  return f.level + dot(f.gradient, r) + f.contrast * inside;
}

double robust_sigma(std::vector<double>& magnitudes) {
  if (magnitudes.empty()) return 0;
  const auto middle = magnitudes.begin() + static_cast<std::ptrdiff_t>(magnitudes.size() / 2);
  std::nth_element(magnitudes.begin(), middle, magnitudes.end());
  return kMadToSigma * *middle;
}

/// Level and contrast that suit the start: medians of what lies outside and inside.
void start_levels(const MarkModel& model, const std::vector<Sample>& samples, ShapeFit& f) {
  std::vector<double> in, out;
  for (const Sample& s : samples) {
    const double sdf = distance(model.shape, Vec2{s.x, s.y} - f.at_px).value;
    if (sdf < -2) in.push_back(s.grey);
    if (sdf > 2) out.push_back(s.grey);
  }
  const auto median = [](std::vector<double>& v) {
    if (v.empty()) return 0.0;
    const auto middle = v.begin() + static_cast<std::ptrdiff_t>(v.size() / 2);
    std::nth_element(v.begin(), middle, v.end());
    return *middle;
  };
  f.level = median(out);
  f.contrast = median(in) - f.level;
  if (std::abs(f.contrast) < 1) f.contrast = model.bright ? 1 : -1;
}

}  // namespace

std::size_t sector_of(Vec2 q) {
  const double turn = std::atan2(q.y, q.x) / (2 * std::numbers::pi) + 0.5;
  return std::min(kSectors - 1, static_cast<std::size_t>(turn * static_cast<double>(kSectors)));
}

double band_px(const MarkModel& model, const FitEffort& effort) {
  return effort.band_px > 0 ? effort.band_px : std::clamp(0.25 * depth_px(model.shape), 4.0, 12.0);
}

ShapeFit fit_shape(const Image& image, const MarkModel& model, const ShapeFit& start, const FitEffort& effort) {
  ShapeFit f = start;
  f.start_px = start.at_px;
  f.gradient = {};
  f.converged = false;
  const std::vector<Sample> samples = samples_near_edge(image, model, start, effort);
  if (samples.size() < 4 * kParameters) return f;
  start_levels(model, samples, f);

  const double grad_unit = 1 / reach_px(model.shape), blur_max = band_px(model, effort) / 2;
  std::vector<double> magnitudes(samples.size()), residuals(samples.size());
  std::vector<Vector> derivatives(samples.size());
  Matrix normal;
  double relax = effort.relax;
  for (int iteration = 0; iteration < effort.iterations; ++iteration) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      residuals[i] = samples[i].grey - linearise(model, f, samples[i], grad_unit, derivatives[i]);
      magnitudes[i] = std::abs(residuals[i]);
    }
    // A hundredth of the contrast is how well a Gaussian describes a real edge: residuals below it are no outliers.
    f.noise = std::max({robust_sigma(magnitudes), 0.5, 0.01 * std::abs(f.contrast)});
    const double cut = kTukey * std::max(f.noise, relax * std::abs(f.contrast));

    normal.setZero();
    Vector right = Vector::Zero();
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double u = residuals[i] / cut;
      if (std::abs(u) >= 1) continue;
      const double weight = (1 - u * u) * (1 - u * u);
      normal.selfadjointView<Eigen::Lower>().rankUpdate(derivatives[i], weight);
      right += (weight * residuals[i]) * derivatives[i];
    }
    normal = normal.selfadjointView<Eigen::Lower>();
    Matrix damped = normal;
    damped.diagonal() *= 1 + 1e-6;
    damped.diagonal().array() += 1e-9;
    const Eigen::LDLT<Matrix> solver(damped);
    if (solver.info() != Eigen::Success) return f;
    const Vector step = solver.solve(right);
    if (!step.allFinite()) return f;

    const double length = std::hypot(step[kX], step[kY]);
    const double share = length > kStepMax_px ? kStepMax_px / length : 1.0;
    f.at_px = f.at_px + Vec2{step[kX], step[kY]} * share;
    f.scale = std::clamp(f.scale + std::clamp(step[kScale], -kStepScale, kStepScale), kScaleMin, kScaleMax);
    f.blur_px = std::clamp(f.blur_px + std::clamp(step[kBlur], -0.4 * f.blur_px, 0.6 * f.blur_px), kBlurMin, blur_max);
    f.level += step[kLevel];
    f.contrast += step[kContrast];
    f.gradient = f.gradient + Vec2{step[kGradX], step[kGradY]} * grad_unit;
    f.converged = relax < 0.02 && length < kConverged_px * effort.stride;
    if (f.converged) break;
    relax *= 0.5;
  }
  // Covariance of a robust estimate is close to noise^2 H^-1 with the weighted normal matrix (efficiency 95 %).
  const Matrix covariance = Eigen::LDLT<Matrix>(normal + 1e-9 * Matrix::Identity()).solve(Matrix::Identity());
  f.sigma_px = {f.noise * std::sqrt(std::max(0.0, covariance(kX, kX))),
                f.noise * std::sqrt(std::max(0.0, covariance(kY, kY)))};
  return f;
}

Expected expected_at(const MarkModel& model, const ShapeFit& f, Vec2 at) {
  const double sdf = f.scale * distance(model.shape, (at - f.at_px) * (1 / f.scale)).value;
  const double z = -sdf / f.blur_px, inside = normal_cdf(z);
  return {f.level + dot(f.gradient, at - f.start_px) + f.contrast * inside, sdf, inside,
          f.contrast * normal_pdf(z) / f.blur_px};
}

}  // namespace gantry::vision
