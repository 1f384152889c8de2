#include "motion/path/fairing.hpp"

#include <algorithm>
#include <cmath>

namespace gantry::motion {
namespace {

constexpr double kUsed = 0.96;       ///< of the room: what is aimed at; weights come near to it from both sides
constexpr int kMostWeighings = 40;   ///< for one set of knots
constexpr int kLeastWeighings = 10;  ///< weights that count for nothing fade
constexpr int kMostRefinings = 12;
constexpr int kPatience = 3;       ///< refinings after which weights that do not settle may only grow
constexpr int kMostHolds = 40;     ///< times that they do
constexpr std::size_t kFine = 16;  ///< places in an interval that are measured at the end

using Four = std::array<double, 4>;

/// Bezier points of an interval from four controls, by blossoms: control n is f(n-1, n, n+1), the Bezier points are
/// f(i, i, i), f(i, i, i+1), f(i, i+1, i+1), f(i+1, i+1, i+1). t: the six knots around it.
std::array<Four, 4> blossoms(const double* t) {
  const auto mix = [](const Four& a, const Four& b, double from, double at, double to) {
    const double x = (at - from) / (to - from);
    return Four{a[0] + x * (b[0] - a[0]), a[1] + x * (b[1] - a[1]), a[2] + x * (b[2] - a[2]), a[3] + x * (b[3] - a[3])};
  };
  constexpr Four c1 = {1, 0, 0, 0}, c2 = {0, 1, 0, 0}, c3 = {0, 0, 1, 0}, c4 = {0, 0, 0, 1};
  const Four b1 = mix(c2, c3, t[1], t[2], t[4]), b2 = mix(c2, c3, t[1], t[3], t[4]);
  const Four left = mix(c1, c2, t[0], t[2], t[3]), right = mix(c3, c4, t[2], t[3], t[5]);
  return {mix(left, b1, t[1], t[2], t[3]), b1, b2, mix(b2, right, t[2], t[3], t[4])};
}

Four at_u(const std::array<Four, 4>& b, double u) {
  const double v = 1 - u;
  const Four w = {v * v * v, 3 * v * v * u, 3 * v * u * u, u * u * u};
  Four out{};
  for (std::size_t n = 0; n < 4; ++n)
    for (std::size_t k = 0; k < 4; ++k) out[k] += w[n] * b[n][k];
  return out;
}

/// A place at which the spline is held to the polyline.
struct Sample {
  std::size_t interval = 0;
  Four basis{};
  AxisVec p{};
  double room = 0, weight = 0;
  double pull = 1;  ///< what its weight has become
};

class Fairing {
 public:
  Fairing(const Measure& m, const Guide& guide, FairEnd begin, FairEnd end, std::vector<double> knots, FairSpline& s)
      : m_(m), guide_(guide), begin_(begin), end_(end), inner_(std::move(knots)), s_(s) {
    if (begin == FairEnd::Given) {
      given_knots_.assign(s.knots.begin(), s.knots.begin() + 5);
      given_.assign(s.controls.begin(), s.controls.begin() + 3);
    }
    const auto all_at = [](const std::vector<AxisVec>& points, std::size_t i, double x) {
      return std::all_of(points.begin(), points.end(), [&](const AxisVec& q) { return q[i] == x; });
    };
    for (std::size_t i = 0; i < m.axes; ++i)
      if (all_at(guide.q, i, guide.q[0][i]) && all_at(given_, i, guide.q[0][i])) standing_.push_back(i);
  }

  bool run() {
    for (int n = 0; n < kMostRefinings; ++n) {
      lay_knots();
      sample();
      const bool settled = weigh();
      if (!settled && n >= kPatience) hold();
      if (!refine()) return true;
    }
    return false;
  }

 private:
  void lay_knots() {
    std::vector<double>& t = s_.knots;
    t.clear();
    if (begin_ == FairEnd::Given)
      t = given_knots_;
    else
      t = {2 * inner_[0] - inner_[2], 2 * inner_[0] - inner_[1]};
    t.insert(t.end(), inner_.begin(), inner_.end());
    const std::size_t n = t.size();
    t.push_back(2 * t[n - 1] - t[n - 2]);
    t.push_back(2 * t[n - 1] - t[n - 3]);
    s_.controls.clear();
    for (std::size_t k = 0, leg = 0; k + 2 < t.size(); ++k) {
      const double at = (t[k] + t[k + 1] + t[k + 2]) / 3;
      while (leg + 2 < guide_.at.size() && guide_.at[leg + 1] <= at) ++leg;
      s_.controls.push_back(on_leg(leg, leg + 1, at));
    }
    fixed_.assign(s_.controls.size(), 0);
    const std::size_t last = s_.controls.size() - 1;
    if (begin_ == FairEnd::Given)
      for (std::size_t k = 0; k < 3; ++k) s_.controls[k] = given_[k], fixed_[k] = 1;
    if (begin_ == FairEnd::Free) fixed_.front() = 1;
    if (end_ == FairEnd::Free) fixed_.back() = 1;
    if (begin_ == FairEnd::OnLeg) lay_on_leg(0, 0, 1);
    if (end_ == FairEnd::OnLeg) lay_on_leg(last - 2, guide_.at.size() - 2, guide_.at.size() - 1);
    basis_.resize(s_.intervals());
    for (std::size_t i = 0; i < s_.intervals(); ++i) basis_[i] = blossoms(&s_.knots[i]);
    set_ends();
  }

  void lay_on_leg(std::size_t first, std::size_t a, std::size_t b) {
    for (std::size_t k = first; k < first + 3; ++k) {
      const double at = (s_.knots[k] + s_.knots[k + 1] + s_.knots[k + 2]) / 3;
      s_.controls[k] = on_leg(a, b, at);
      fixed_[k] = 1;
    }
  }

  [[nodiscard]] AxisVec on_leg(std::size_t a, std::size_t b, double at) const {
    const double x = (at - guide_.at[a]) / (guide_.at[b] - guide_.at[a]);
    AxisVec out = guide_.q[a];
    for (std::size_t i = 0; i < m_.axes; ++i) out[i] += x * (guide_.q[b][i] - guide_.q[a][i]);
    return out;
  }

  [[nodiscard]] double length_of(std::size_t interval) const {
    return s_.begin_of(interval + 1) - s_.begin_of(interval);
  }

  // Visits places of an interval: its vertices, and some evenly. visit(s, leg, room)
  template <class Visit>
  void places(std::size_t interval, std::size_t evenly, std::size_t& leg, Visit&& visit) const {
    const double a = s_.begin_of(interval), b = s_.begin_of(interval + 1), h = b - a;
    const std::size_t legs = guide_.at.size() - 1;
    const auto put = [&](double s, bool vertex) {
      double room = guide_.room_mm[leg];
      if (vertex && leg > 0) room = std::min(room, guide_.room_mm[leg - 1]);
      visit(s, leg, room);
    };
    for (std::size_t k = 0; k < evenly; ++k) {
      const double s = a + h * static_cast<double>(k) / static_cast<double>(evenly);
      while (leg + 1 < legs && guide_.at[leg + 1] <= s) {
        ++leg;
        if (guide_.at[leg] > a) put(guide_.at[leg], true);
      }
      put(s, false);
    }
    while (leg + 1 < legs && guide_.at[leg + 1] <= b) {
      ++leg;
      put(guide_.at[leg], true);
    }
  }

  void sample() {
    samples_.clear();
    stiff_.assign(s_.intervals(), 1);
    std::size_t leg = 0;
    for (std::size_t i = 0; i < s_.intervals(); ++i) {
      const double a = s_.begin_of(i), h = length_of(i);
      const double scale = 1 / (64 * h * h * h * h * h);  // |d|^2 against |q'''|^2 of a wave of some intervals
      places(i, 4, leg, [&](double s, std::size_t on, double room) {
        Sample x{i, at_u(basis_[i], (s - a) / h), on_leg(on, on + 1, s), room * kUsed, 0.25 * scale, 1};
        samples_.push_back(x);
      });
    }
  }

  // Lawson's rule: a sample that is off by more than its room weighs more, others less.
  // False: they do not settle.
  bool weigh() {
    for (int n = 0; n < kMostWeighings; ++n) {
      solve();
      double worst = 0;
      for (Sample& x : samples_) {
        if (!(x.room > 0)) continue;
        const double off = distance(x) / x.room;
        worst = std::max(worst, off);
        x.pull *= std::clamp(off * off, 0.02, 50.0);
        x.pull = std::max(x.pull, 1e-7);
      }
      if (n >= kLeastWeighings && worst <= 1.02) return true;
      stiffen();
    }
    return false;
  }

  // Where many samples hold the spline, their weights chase each other, and no knot helps. Then weights only grow,
  // until each sample is within its room.
  void hold() {
    for (int n = 0; n < kMostHolds; ++n) {
      solve();
      bool held = true;
      for (Sample& x : samples_) {
        if (!(x.room > 0)) continue;
        const double off = distance(x) / x.room;
        if (off > 1.02) x.pull *= std::min(off * off, 50.0), held = false;
      }
      if (held) return;
    }
  }

  /// The third derivative in an interval, from its controls.
  [[nodiscard]] Four third_of(std::size_t interval) const {
    const auto& b = basis_[interval];
    const double h = length_of(interval);
    Four out{};
    for (std::size_t k = 0; k < 4; ++k) out[k] = 6 * (b[3][k] - 3 * b[2][k] + 3 * b[1][k] - b[0][k]) / (h * h * h);
    return out;
  }

  // The squares of |q'''| weighed with |q'''|^2 are its fourth powers. Weights go a third of the way (as logarithms)
  // each time: all of it would swing (Burrus, "Iterative reweighted least squares", on norms p > 3: 1/(p - 1)).
  void stiffen() {
    constexpr double kStep = 1.0 / 3, kLeast = 1e-3;
    std::vector<double> square(s_.intervals());
    double most = 0;
    for (std::size_t n = 0; n < square.size(); ++n) {
      const Four third = third_of(n);
      AxisVec sum{};
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t i = 0; i < m_.axes; ++i) sum[i] += third[k] * s_.controls[n + k][i];
      const double size = aside(m_, sum);
      most = std::max(most, square[n] = size * size);
    }
    if (!(most > 0)) return;
    for (std::size_t n = 0; n < square.size(); ++n)
      stiff_[n] *= std::pow(std::max(kLeast, square[n] / most) / stiff_[n], kStep);
  }

  [[nodiscard]] double distance(const Sample& x) const {
    AxisVec off{};
    for (std::size_t i = 0; i < m_.axes; ++i) {
      double q = 0;
      for (std::size_t k = 0; k < 4; ++k) q += x.basis[k] * s_.controls[x.interval + k][i];
      off[i] = q - x.p[i];
    }
    return aside(m_, off);
  }

  /// A row of the sum of squares: weight (sum g (c + change) - p)^2. The outer control of a free end changes by what
  /// the end's place makes of the two beside it.
  void add(std::size_t interval, Four g, double weight, const AxisVec* p) {
    AxisVec want = p != nullptr ? *p : AxisVec{};
    for (std::size_t i = 0; i < m_.axes; ++i)
      for (std::size_t k = 0; k < 4; ++k) want[i] -= g[k] * s_.controls[interval + k][i];
    if (begin_ == FairEnd::Free && interval == 0) {
      const Four& e = basis_.front()[0];
      const double share = g[0] / e[0];
      g[1] -= share * e[1], g[2] -= share * e[2];
    }
    if (end_ == FairEnd::Free && interval + 1 == s_.intervals()) {
      const Four& e = basis_.back()[3];
      const double share = g[3] / e[3];
      g[2] -= share * e[2], g[1] -= share * e[1];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      if (fixed_[interval + k] != 0) continue;
      for (std::size_t l = k; l < 4; ++l)
        if (fixed_[interval + l] == 0) band_[interval + l][l - k] += weight * g[k] * g[l];
      for (std::size_t i = 0; i < m_.axes; ++i) right_[interval + k][i] += weight * g[k] * want[i];
    }
  }

  // Solves for the change of the controls that are there: its rounding is a share of that change, so that weighings
  // take it away again, and an axis that depends linearly on others goes on to.
  void solve() {
    const std::size_t n = s_.controls.size();
    band_.assign(n, Four{});
    right_.assign(n, AxisVec{});
    for (std::size_t i = 0; i < s_.intervals(); ++i) {
      add(i, third_of(i), length_of(i) * stiff_[i], nullptr);
    }
    for (const Sample& x : samples_) add(x.interval, x.basis, x.weight * x.pull, &x.p);
    factor();
    for (std::size_t k = 0; k < n; ++k) {
      if (fixed_[k] != 0) continue;
      for (std::size_t i = 0; i < m_.axes; ++i) s_.controls[k][i] += right_[k][i];
    }
    set_ends();
    // An axis that stands does so to the last bit: equality tells whoever asks which axes a bead moves.
    for (AxisVec& control : s_.controls)
      for (const std::size_t i : standing_) control[i] = guide_.q[0][i];
  }

  /// band_ is L D L' by rows: [k][d] couples k with k - d. right_ becomes the solution.
  void factor() {
    const std::size_t n = band_.size();
    for (std::size_t k = 0; k < n; ++k) {
      if (fixed_[k] != 0) band_[k] = {1, 0, 0, 0};
      for (std::size_t d = std::min<std::size_t>(3, k); d > 0; --d) {
        double x = band_[k][d];
        for (std::size_t e = d + 1; e <= std::min<std::size_t>(3, k); ++e)
          x -= band_[k][e] * band_[k - e][0] * band_[k - d][e - d];
        band_[k][d] = x / band_[k - d][0];
      }
      for (std::size_t d = 1; d <= std::min<std::size_t>(3, k); ++d) {
        band_[k][0] -= band_[k][d] * band_[k][d] * band_[k - d][0];
        for (std::size_t i = 0; i < m_.axes; ++i) right_[k][i] -= band_[k][d] * right_[k - d][i];
      }
    }
    for (std::size_t k = n; k-- > 0;)
      for (std::size_t i = 0; i < m_.axes; ++i) {
        double x = right_[k][i] / band_[k][0];
        for (std::size_t d = 1; d <= 3 && k + d < n; ++d) x -= band_[k + d][d] * right_[k + d][i];
        right_[k][i] = x;
      }
  }

  void set_ends() {
    auto& c = s_.controls;
    const std::size_t last = c.size() - 1;
    for (std::size_t i = 0; i < m_.axes; ++i) {
      if (begin_ == FairEnd::Free) {
        const Four& g = basis_.front()[0];
        c[0][i] = (guide_.q.front()[i] - g[1] * c[1][i] - g[2] * c[2][i]) / g[0];
      }
      if (end_ == FairEnd::Free) {
        const Four& g = basis_.back()[3];
        c[last][i] = (guide_.q.back()[i] - g[2] * c[last - 1][i] - g[1] * c[last - 2][i]) / g[3];
      }
    }
  }

  /// Halves intervals that leave the tube. True: there were some.
  bool refine() {
    std::vector<double> finer;
    std::size_t leg = 0;
    const double from = inner_.front(), free_from = begin_ == FairEnd::Given ? given_knots_[4] : from;
    bool any = false;
    std::vector<char> halve(s_.intervals(), 0);
    for (std::size_t i = 0; i < s_.intervals(); ++i) {
      const double a = s_.begin_of(i), h = length_of(i);
      places(i, kFine, leg, [&](double s, std::size_t on, double room) {
        const Sample x{i, at_u(basis_[i], (s - a) / h), on_leg(on, on + 1, s), room, 0, 1};
        if (distance(x) > 0.995 * room) halve[i] = 1, any = true;
      });
    }
    if (!any) return false;
    for (std::size_t i = 0; i < s_.intervals(); ++i) {
      const double a = s_.begin_of(i), b = s_.begin_of(i + 1);
      if (a >= from) finer.push_back(a);
      const bool near = halve[i] != 0 || (i > 0 && halve[i - 1] != 0) || (i + 1 < s_.intervals() && halve[i + 1] != 0);
      if (near && a >= free_from) finer.push_back((a + b) / 2);
    }
    finer.push_back(s_.begin_of(s_.intervals()));
    if (finer.size() == inner_.size()) return true;  // only what is given is off: more weighings
    inner_ = std::move(finer);
    return true;
  }

  const Measure& m_;
  const Guide& guide_;
  FairEnd begin_, end_;
  std::vector<double> inner_;
  FairSpline& s_;
  std::vector<double> given_knots_;
  std::vector<AxisVec> given_;
  std::vector<std::size_t> standing_;  ///< axes that have one value all along
  std::vector<char> fixed_;
  std::vector<std::array<Four, 4>> basis_;
  std::vector<Sample> samples_;
  std::vector<double> stiff_;  ///< weight of the third derivative in an interval
  std::vector<Four> band_;
  std::vector<AxisVec> right_;
};

}  // namespace

std::array<AxisVec, 4> FairSpline::bezier(std::size_t interval) const {
  const auto b = blossoms(&knots[interval]);
  const AxisVec* c = &controls[interval];
  std::array<AxisVec, 4> out{};
  for (std::size_t n = 0; n < 4; ++n)
    for (std::size_t i = 0; i < kMaxAxes; ++i) {
      if (c[0][i] == c[1][i] && c[0][i] == c[2][i] && c[0][i] == c[3][i]) {
        out[n][i] = c[0][i];  // shares whose sum is 1 but for its rounding would give nearly that
        continue;
      }
      for (std::size_t k = 0; k < 4; ++k) out[n][i] += b[n][k] * c[k][i];
    }
  return out;
}

bool fair(const Measure& m, const Guide& guide, FairEnd begin, FairEnd end, std::vector<double> knots,
          FairSpline& spline) {
  return Fairing(m, guide, begin, end, std::move(knots), spline).run();
}

}  // namespace gantry::motion
