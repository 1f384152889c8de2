#include "bench/path_smooth/smooth_curve.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

namespace gantry::bench {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kStep_mm = 0.01;  // between dense points

double norm(const Point& a) { return std::hypot(a[0], a[1], a[2]); }
Point minus(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// The least radius of the circles through three points of a parametric curve.
double least_radius(const std::function<Point(double)>& at, double end) {
  constexpr int kPlaces = 4000;
  double least = 1e9;
  const double h = end / kPlaces;
  for (int k = 1; k < kPlaces; ++k) {
    const Point a = at((k - 1) * h), b = at(k * h), c = at((k + 1) * h);
    const double area = norm(cross(minus(b, a), minus(c, a)));
    if (area > 0) least = std::min(least, norm(minus(b, a)) * norm(minus(c, b)) * norm(minus(c, a)) / (2 * area));
  }
  return least;
}

/// Points at even steps of arc length.
std::vector<Point> evenly(const std::function<Point(double)>& at, double end) {
  std::vector<Point> out{at(0)};
  double t = 0, per = 1e-6;  // parameter for a step
  while (t < end) {
    double step = per * kStep_mm;
    for (int n = 0; n < 20; ++n) {
      const double d = norm(minus(at(t + step), out.back()));
      if (std::abs(d - kStep_mm) < 1e-9 * kStep_mm) break;
      step *= d > 0 ? std::clamp(kStep_mm / d, 0.1, 10.0) : 10;
    }
    per = step / kStep_mm, t += step;
    out.push_back(at(t));
  }
  return out;
}

/// A plane curve of given curvature over arc length, by the middle of each step.
std::vector<Point> of_curvature(const std::function<double(double)>& curvature, double length, double angle) {
  std::vector<Point> out{{}};
  Point p{};
  for (double s = 0; s < length; s += kStep_mm) {
    const double bend = curvature(s + kStep_mm / 2) * kStep_mm;
    angle += bend / 2;
    p[0] += kStep_mm * std::cos(angle), p[1] += kStep_mm * std::sin(angle);
    angle += bend / 2;
    out.push_back(p);
  }
  return out;
}

class Draw {
 public:
  Draw(std::uint64_t seed, double least_mm) : random_(seed), least_mm_(least_mm) {}

  SmoothCurve curve() {
    switch (std::uniform_int_distribution<int>(0, 8)(random_)) {
      case 0: return {"sine", sine(), {}};
      case 1: return {"ellipse", ellipse(), {}};
      case 2: return {"lissajous", lissajous(), {}};
      case 3: return {"fourier", fourier(), {}};
      case 4: return {"spiral", spiral(), {}};
      case 5: return {"helix", helix(), {}};
      case 6: return {"wandering", wandering(), {}};
      case 7: return {"lines_and_arcs", lines_and_arcs(), {}};
      default: return {"rounded_rectangle", rounded_rectangle(), {}};
    }
  }
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

 private:
  /// Scaled so that its least radius is 1 to 4 times the least that is asked.
  std::vector<Point> scaled(const std::function<Point(double)>& at, double end) {
    const double by = least_mm_ * 1.0001 * real(1, 4) / least_radius(at, end), angle = real(0, 2 * kPi);
    const double c = by * std::cos(angle), s = by * std::sin(angle);
    return evenly(
        [&, by](double t) {
          const Point p = at(t);
          return Point{c * p[0] - s * p[1], s * p[0] + c * p[1], by * p[2]};
        },
        end);
  }
  std::vector<Point> sine() {
    const double height = real(0.02, 0.3);
    return scaled([=](double t) { return Point{t, height * std::sin(t), 0}; }, real(4, 20));
  }
  std::vector<Point> ellipse() {
    const double flat = real(0.4, 1);
    return scaled([=](double t) { return Point{std::cos(t), flat * std::sin(t), 0}; }, 2 * kPi);
  }
  std::vector<Point> lissajous() {
    const double phase = real(-0.4, 0.4);
    return scaled([=](double t) { return Point{std::sin(t), std::sin(2 * t + phase), 0}; }, 2 * kPi);
  }
  std::vector<Point> fourier() {
    std::array<double, 6> amplitude{}, phase{};
    for (std::size_t k = 0; k < amplitude.size(); ++k) {
      const double order = static_cast<double>(k + 2);
      amplitude[k] = real(0, 0.25) / (order * order), phase[k] = real(0, 2 * kPi);
    }
    return scaled(
        [=](double t) {
          double r = 1;
          for (std::size_t k = 0; k < amplitude.size(); ++k)
            r += amplitude[k] * std::cos(static_cast<double>(k + 2) * t + phase[k]);
          return Point{r * std::cos(t), r * std::sin(t), 0};
        },
        2 * kPi);
  }
  std::vector<Point> spiral() {
    const double pitch = real(0.02, 0.15);
    return scaled(
        [=](double t) {
          return Point{(1 + pitch * t) * std::cos(t), (1 + pitch * t) * std::sin(t), 0};
        },
        real(5, 20));
  }
  std::vector<Point> helix() {
    const double rise = real(0.02, 0.3);
    return scaled([=](double t) { return Point{std::cos(t), std::sin(t), rise * t}; }, real(5, 20));
  }
  std::vector<Point> wandering() {
    std::array<double, 5> wave{}, phase{}, size{};
    double all = 0;
    for (std::size_t k = 0; k < wave.size(); ++k)
      wave[k] = real(40, 200), phase[k] = real(0, 2 * kPi), all += size[k] = real(0, 1);
    const double most = 1 / least_mm_ / all;
    return of_curvature(
        [=](double s) {
          double sum = 0;
          for (std::size_t k = 0; k < wave.size(); ++k) sum += size[k] * std::sin(2 * kPi * s / wave[k] + phase[k]);
          return most * sum;
        },
        real(80, 500), real(0, 2 * kPi));
  }
  std::vector<Point> lines_and_arcs() {
    std::vector<std::pair<double, double>> parts;  // until, curvature
    double s = 0;
    const int n = std::uniform_int_distribution<int>(2, 8)(random_);
    for (int k = 0; k < n; ++k) {
      parts.emplace_back(s += real(5, 60), 0);
      const double r = least_mm_ * real(1, 5);
      parts.emplace_back(s += r * real(0.3, kPi), (real(0, 1) < 0.5 ? -1 : 1) / r);
    }
    parts.emplace_back(s += real(5, 60), 0);
    return of_curvature(
        [=](double at) {
          for (const auto& [until, curvature] : parts)
            if (at < until) return curvature;
          return 0.0;
        },
        s, real(0, 2 * kPi));
  }
  std::vector<Point> rounded_rectangle() {
    const double r = least_mm_ * real(1, 3), a = real(5, 80), b = real(5, 80), quarter = r * kPi / 2;
    const double half = a + b + 2 * quarter;
    return of_curvature(
        [=](double at) {
          const double s = std::fmod(at, half);
          return s < a || (s >= a + quarter && s < a + quarter + b) ? 0 : 1 / r;
        },
        2 * half, real(0, 2 * kPi));
  }

  std::mt19937_64 random_;
  double least_mm_;
};

}  // namespace

SmoothCurve draw_curve(std::uint64_t seed, double least_radius_mm) {
  Draw draw(seed, least_radius_mm);
  SmoothCurve out = draw.curve();
  const auto every = static_cast<std::size_t>(std::pow(10.0, draw.real(1, 2)));
  for (std::size_t k = 0; k < out.dense.size(); k += every) out.chords.push_back(out.dense[k]);
  if (out.chords.back() != out.dense.back()) out.chords.push_back(out.dense.back());
  return out;
}

}  // namespace gantry::bench
