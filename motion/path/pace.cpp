// Primal-dual interior-point method. Unknown is b(s) = v^2, a quadratic spline over the nodes: a = b'/2, da/ds = b''/2.
// An axis has
//   |q'| v <= V,   |q'' b + q' a| <= A,   |q''' b + 3 q'' a + q' b''/2| <= J / sqrt(b).
// All are linear in b but the right side of the last, which is convex: its tangent is a stricter limit. Time is convex
// in b. Each limit c(b) >= 0 has a slack s and a price z; Newton's method on  grad(time) = sum z grad(c),  c = s,
// s z = mu, with mu to 0. The system in b has five diagonals.
// From rest, jerk is constant over the first cell: s = j t^3/6, hence b' = 4/3 b/s at its end and j = 2/9 b^(3/2)/s^2;
// likewise before the end.
#include "motion/path/pace.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <tuple>

namespace gantry::motion {
namespace {

constexpr double kUseV = 0.9999, kUseA = 0.9995, kUseJ = 0.9985;  ///< of the limits: nodes are not everywhere
constexpr double kGap = 3e-4;         ///< of the duration: what prices and slacks may still promise at the end
constexpr double kInfeasible = 1e-6;  ///< of a limit
constexpr double kNearly = 0.995;     ///< of the step with which a slack or a price would become 0
constexpr int kMostSteps = 100;

using Local = std::array<double, 3>;

/// |g . c| <= bound (Kind::Fixed) or bound / sqrt(b) somewhere in the cell.
enum class Kind : std::uint8_t { Fixed, Left, Middle, Right };
struct Row {
  Local g{};
  double bound = 0;
  Kind kind = Kind::Fixed;
};

/// A cell between nodes: three coefficients of the spline count in it.
struct Span {
  double length = 0;
  Local left{}, middle{}, right{};  ///< b at its ends and in between
  double cap = 0;                   ///< of b at its left end
  std::size_t first_row = 0, end_row = 0;
};

double dot(const Local& a, const double* c) { return a[0] * c[0] + a[1] * c[1] + a[2] * c[2]; }

class Solver {
 public:
  explicit Solver(const PaceProblem& p) : p_(p), cells_(p.cells) {
    from_rest_ = p.from_rest;
    first_ = from_rest_ ? 1 : 0;
    end_ = p.cells.size() - 1;  // the last cell is played at constant jerk
    n_ = end_ - first_;
    build();
  }

  Pace solve(const Pace* near) {
    Pace out;
    const bool warm = near != nullptr;
    start(near);
    double worst = 0;  // share of a limit by which it is not kept yet
    int followed = 0;
    bool done = false;
    double time = duration(c_);
    std::vector<double> best = ratio(c_) < 1 ? c_ : std::vector<double>{};
    set_slacks((warm ? 0.01 : 0.3) * time / static_cast<double>(2 * rows_.size() + n_ + 1));
    double before = 2 * time, size = 0, mu = (warm ? 0.01 : 0.3) * time / static_cast<double>(prices_.size());
    for (out.steps = 0; out.steps < kMostSteps; ++out.steps) {
      // Steps are long near the path of centres: only there mu goes down.
      if (size > 0.8 && std::abs(before - time) < gap_ && worst <= kInfeasible) mu *= 0.12;
      before = time;
      size = step(mu);
      if (!(size > 0)) break;
      worst = update_slacks();
      time = duration(c_);
      if (!std::isfinite(time)) break;
      if (worst > kInfeasible) continue;
      best = c_;
      constexpr std::array<double, 3> kFollowAt = {0.05, 0.01, 0.002};
      if (followed < 3 && gap_ < kFollowAt[static_cast<std::size_t>(followed)] * time) {
        ++followed;
        follow_halves();
        worst = update_slacks();
        continue;
      }
      if (followed == 3 && gap_ < kGap * time) {
        done = true;
        break;
      }
    }
    // Every point inside keeps the limits: where the method sticks, the best one so far is a plan, if not the fastest.
    if (!done) c_ = best;
    if (best.empty()) return out;
    out.solved = true;
    out.nodes = nodes(c_);
    out.spline = c_;
    return out;
  }

 private:
  [[nodiscard]] const PaceCell& cell(std::size_t k) const { return cells_[first_ + k]; }
  // Control point k + 1 lies in cell k, (1 - weight) of its length from its begin; the first and the last lie on the
  // ends. Distances from node k back to the control point before it and on to the one after it:
  [[nodiscard]] double before(std::ptrdiff_t k) const {
    return k < 1 ? 0 : cell(static_cast<std::size_t>(k - 1)).length * cell(static_cast<std::size_t>(k - 1)).weight;
  }
  [[nodiscard]] double after(std::ptrdiff_t k) const {
    if (k >= static_cast<std::ptrdiff_t>(n_)) return 0;
    return cell(static_cast<std::size_t>(k)).length * (1 - cell(static_cast<std::size_t>(k)).weight);
  }

  void build() {
    spans_.assign(n_, {});
    rows_.clear();
    for (std::size_t k = 0; k < n_; ++k) {
      const auto i = static_cast<std::ptrdiff_t>(k);
      // Distances of the nodes from the control points before and after them.
      const double l0 = before(i), l1 = after(i), r0 = before(i + 1), r1 = after(i + 1);
      const PaceCell& c = cell(k);
      share_ = c.share;
      Span& s = spans_[k];
      s.length = c.length;
      s.left = {l1 / (l0 + l1), l0 / (l0 + l1), 0};
      s.right = {0, r1 / (r0 + r1), r0 / (r0 + r1)};
      const Local slope_left = {-0.5 / (l0 + l1), 0.5 / (l0 + l1), 0};  // a = b'/2
      const Local slope_right = {0, -0.5 / (r0 + r1), 0.5 / (r0 + r1)};
      for (std::size_t j = 0; j < 3; ++j)  // b' falls or rises evenly
        s.middle[j] = s.left[j] + c.length * (0.75 * slope_left[j] + 0.25 * slope_right[j]);
      Local bend{};  // jerk / mean speed
      for (std::size_t j = 0; j < 3; ++j) bend[j] = (slope_right[j] - slope_left[j]) / c.length;
      const auto times = [](const Local& x, double f) { return Local{x[0] * f, x[1] * f, x[2] * f}; };
      const Local bend_left = times(bend, c.mean_by_begin), bend_right = times(bend, c.mean_by_end);
      s.first_row = rows_.size();
      s.cap = k > 0 ? std::min(cap(cell(k - 1)), cap(c)) : cap(c);
      if (p_.hull) add({0, 1, 0}, cap(c), Kind::Fixed);  // a spline lies between its control points
      if (c.straight) {
        add_straight(c.begin.d1, slope_left);
        add_straight_jerk(c.begin.d1, bend_left, Kind::Left);
        add_straight_jerk(c.begin.d1, bend_right, Kind::Right);
      } else {
        add_acceleration(c.begin, s.left, slope_left);
        add_jerk(c.begin, s.left, slope_left, bend_left, Kind::Left);
        const Local slope{(slope_left[0] + slope_right[0]) / 2, (slope_left[1] + slope_right[1]) / 2,
                          (slope_left[2] + slope_right[2]) / 2};
        add_jerk(c.middle, s.middle, slope, times(bend, c.mean_before_middle), Kind::Middle);
        add_jerk(c.middle, s.middle, slope, times(bend, c.mean_after_middle), Kind::Middle);
        add_jerk(c.end, s.right, slope_right, bend_right, Kind::Right);
      }
      s.end_row = rows_.size();
    }
    if (from_rest_) {
      const double s1 = p_.cells.front().length;
      share_ = p_.cells.front().share;
      spans_[0].cap = std::min(spans_[0].cap, rest_cap(p_.cells.front().end, s1));
      fold_first_ = 1 / (1 + 4.0 / 3 * after(0) / s1);  // c0 = fold c1
    }
    const double s2 = p_.cells.back().length;
    share_ = p_.cells.back().share;
    last_cap_ = std::min(cap(cell(n_ - 1)), rest_cap(p_.cells.back().begin, s2));
    fold_last_ = 1 / (1 + 4.0 / 3 * before(static_cast<std::ptrdiff_t>(n_)) / s2);
  }

  /// Of v^2, in a whole cell.
  [[nodiscard]] double cap(const PaceCell& c) const {
    double v = p_.v_set;
    for (std::size_t i = 0; i < p_.limits.axes; ++i) {
      double most = std::abs(c.begin.d1[i]);
      if (!c.straight) most = std::max({most, std::abs(c.middle.d1[i]), std::abs(c.end.d1[i])});
      if (most > 0) v = std::min(v, p_.limits.axis[i].v_max / most);
    }
    return kUseV * kUseV * c.share * c.share * v * v;
  }

  /// Limits of axis i in the cell that is being built.
  [[nodiscard]] double a_max(std::size_t i) const { return kUseA * share_ * share_ * p_.limits.axis[i].a_max; }
  [[nodiscard]] double j_max(std::size_t i) const { return kUseJ * share_ * share_ * share_ * p_.limits.axis[i].j_max; }

  // Highest b at the end of a first cell of length s1 at constant jerk from rest; terms added up by size, so that it
  // holds inside of the cell too.
  [[nodiscard]] double rest_cap(const CurveJet& x, double s1) const {
    double b = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < p_.limits.axes; ++i) {
      const double q1 = std::abs(x.d1[i]), q2 = std::abs(x.d2[i]), q3 = std::abs(x.d3[i]);
      const double acceleration = q2 + q1 * 2 / (3 * s1), jerk = q3 + 2 * q2 / s1 + q1 * 2 / (9 * s1 * s1);
      if (acceleration > 0) b = std::min(b, a_max(i) / acceleration);
      if (jerk > 0) b = std::min(b, std::pow(j_max(i) / jerk, 2.0 / 3));
    }
    return b;
  }

  void add(const Local& g, double bound, Kind kind) {
    Row r{{g[0] / bound, g[1] / bound, g[2] / bound}, 1, kind};
    rows_.push_back(r);
  }
  void add_straight(const AxisVec& d1, const Local& slope) {
    double most = 0;
    for (std::size_t i = 0; i < p_.limits.axes; ++i) most = std::max(most, std::abs(d1[i]) / a_max(i));
    add({slope[0] * most, slope[1] * most, slope[2] * most}, 1, Kind::Fixed);
  }
  void add_straight_jerk(const AxisVec& d1, const Local& bend, Kind kind) {
    double most = 0;
    for (std::size_t i = 0; i < p_.limits.axes; ++i) most = std::max(most, std::abs(d1[i]) / j_max(i));
    add({bend[0] * most, bend[1] * most, bend[2] * most}, 1, kind);
  }
  void add_acceleration(const CurveJet& x, const Local& b, const Local& a) {
    for (std::size_t i = 0; i < p_.limits.axes; ++i) {
      if (x.d1[i] == 0 && x.d2[i] == 0) continue;
      Local g;
      for (std::size_t j = 0; j < 3; ++j) g[j] = x.d2[i] * b[j] + x.d1[i] * a[j];
      add(g, a_max(i), Kind::Fixed);
    }
  }
  void add_jerk(const CurveJet& x, const Local& b, const Local& a, const Local& bend, Kind kind) {
    for (std::size_t i = 0; i < p_.limits.axes; ++i) {
      if (x.d1[i] == 0 && x.d2[i] == 0 && x.d3[i] == 0) continue;
      Local g;
      for (std::size_t j = 0; j < 3; ++j) g[j] = x.d3[i] * b[j] + 3 * x.d2[i] * a[j] + x.d1[i] * bend[j];
      add(g, j_max(i), kind);
    }
  }

  /// Coefficients from the guess; slower until all limits are kept, or with more generous limits where the start moves.
  void start(const Pace* near) {
    c_.assign(n_ + 2, 0);
    const auto guess = [&](std::size_t k) {  // b at the left end of span k
      const double v = p_.cells[first_ + k - 1].v_guess;
      return v * v;
    };
    const auto first = guess(from_rest_ ? 0 : 1);
    for (std::size_t k = 0; k <= n_ + 1; ++k) {
      const std::size_t l = std::min(k > 0 ? k - 1 : 0, n_), r = std::min(k, n_);
      c_[k] = ((l == 0 ? first : guess(l)) + (r == 0 ? first : guess(r))) / 2;
    }
    fold(c_);
    if (near != nullptr && near->spline.size() == c_.size()) c_ = near->spline;
    const double need = ratio(c_) * (near != nullptr ? 1.02 : 1.3);
    for (double& x : c_) x /= need * need;
  }

  // A cell is played as two halves of constant jerk (timing.cpp), which differ from da/ds v at its ends as v does.
  void follow_halves() {
    const std::vector<PaceNode> at = nodes(c_);
    for (std::size_t k = 0; k < n_; ++k) {
      PaceCell& c = cells_[first_ + k];
      const PaceNode &x = at[first_ + k], &y = at[first_ + k + 1];
      const double sum = x.v + y.v, change = x.a - y.a;
      const double half = 2 * c.length / (sum + std::sqrt(std::max(0.0, sum * sum + 4 * change * c.length / 3)));
      const double middle = (y.v - x.v) / half - (x.a + y.a) / 2;
      const double begin = (middle - x.a) / half / x.v, end = (y.a - middle) / half / y.v, mean = -change / c.length;
      const bool near_zero = std::abs(change) < 1e-6 * (std::abs(x.a) + std::abs(y.a)) || change == 0;
      const auto factor = [&](double of) { return near_zero ? 1 : std::clamp(of / mean, 0.2, 5.0); };
      const double v_middle = std::sqrt(dot(spans_[k].middle, &c_[k]));
      c.mean_by_begin = factor(begin), c.mean_by_end = factor(end);
      c.mean_before_middle = factor(begin * x.v / v_middle), c.mean_after_middle = factor(end * y.v / v_middle);
    }
    build();
  }

  void fold(std::vector<double>& c) const {
    if (from_rest_) c[0] = fold_first_ * c[1];
    c[n_ + 1] = fold_last_ * c[n_];
  }

  /// By what factor the motion would have to be slower to keep all limits.
  [[nodiscard]] double ratio(const std::vector<double>& c) const {
    double v2 = 0, a2 = 0, j3 = 0;
    for (std::size_t k = 0; k < n_; ++k) {
      const Span& s = spans_[k];
      const double left = dot(s.left, &c[k]), middle = dot(s.middle, &c[k]), right = dot(s.right, &c[k]);
      if (!(left > 0) || !(middle > 0) || !(right > 0)) return std::numeric_limits<double>::infinity();
      v2 = std::max(v2, left / s.cap);
      for (std::size_t r = s.first_row; r < s.end_row; ++r) {
        const double x = std::abs(dot(rows_[r].g, &c[k]));
        if (rows_[r].kind == Kind::Fixed)
          a2 = std::max(a2, x);
        else
          j3 = std::max(j3, x * std::sqrt(rows_[r].kind == Kind::Left    ? left
                                          : rows_[r].kind == Kind::Right ? right
                                                                         : middle));
      }
    }
    v2 = std::max(v2, dot(spans_[n_ - 1].right, &c[n_ - 1]) / last_cap_);
    return std::max({std::sqrt(v2), std::sqrt(a2), std::cbrt(j3)});
  }

  [[nodiscard]] double duration(const std::vector<double>& c) const {
    double sum = 0;
    if (from_rest_) sum += 3 * p_.cells.front().length / std::sqrt(dot(spans_[0].left, c.data()));
    for (std::size_t k = 0; k < n_; ++k) {
      const Span& s = spans_[k];
      sum += s.length / 6 *
             (1 / std::sqrt(dot(s.left, &c[k])) + 4 / std::sqrt(dot(s.middle, &c[k])) +
              1 / std::sqrt(dot(s.right, &c[k])));
    }
    return sum + 3 * p_.cells.back().length / std::sqrt(dot(spans_[n_ - 1].right, &c[n_ - 1]));
  }

  struct Sums {
    Local gradient{};
    std::array<Local, 3> second{};  // upper triangle
    void add(const Local& g, double first, double curvature) {
      for (std::size_t i = 0; i < 3; ++i) {
        gradient[i] += first * g[i];
        for (std::size_t j = i; j < 3; ++j) second[i][j] += curvature * g[i] * g[j];
      }
    }
    void add_mixed(const Local& g, const Local& e, double curvature) {
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = i; j < 3; ++j) second[i][j] += curvature * (g[i] * e[j] + g[j] * e[i]);
    }
  };

  // What the rows of a span have in common: bound and b, where b counts in the bound.
  struct Part {
    double b, bound, slope;
  };
  using Parts = std::array<Part, 4>;
  [[nodiscard]] Parts parts(std::size_t k) const {
    const auto part = [](double b) {
      const double bound = 1 / std::sqrt(b);
      return Part{b, bound, -0.5 * bound / b};
    };
    const Span& s = spans_[k];
    const double* c = &c_[k];
    return {Part{0, 1, 0}, part(dot(s.left, c)), part(dot(s.middle, c)), part(dot(s.right, c))};
  }
  [[nodiscard]] static const Local& place(const Span& s, Kind kind) {
    return kind == Kind::Left ? s.left : kind == Kind::Middle ? s.middle : s.right;
  }

  // Prices: two for each row (upper, lower side), then one for the speed at each node.
  [[nodiscard]] std::size_t cap_of(std::size_t node) const { return 2 * rows_.size() + node; }
  [[nodiscard]] double cap_room(std::size_t node) const {
    return node < n_ ? 1 - dot(spans_[node].left, &c_[node]) / spans_[node].cap
                     : 1 - dot(spans_[n_ - 1].right, &c_[n_ - 1]) / last_cap_;
  }

  template <class Visit>  // visit(price number, room, its scale)
  void each_limit(Visit&& visit) const {
    for (std::size_t k = 0; k < n_; ++k) {
      const Parts at = parts(k);
      for (std::size_t r = spans_[k].first_row; r < spans_[k].end_row; ++r) {
        const double l = dot(rows_[r].g, &c_[k]), b = at[static_cast<std::size_t>(rows_[r].kind)].bound;
        visit(2 * r, b - l, b);
        visit(2 * r + 1, b + l, b);
      }
    }
    for (std::size_t k = 0; k <= n_; ++k) visit(cap_of(k), cap_room(k), 1.0);
  }

  void set_slacks(double mu) {
    prices_.assign(2 * rows_.size() + n_ + 1, 0);
    slacks_.assign(prices_.size(), 1);
    gap_ = 0;
    each_limit([&](std::size_t i, double room, double scale) {
      slacks_[i] = std::max(room, 0.1 * scale);
      prices_[i] = mu / slacks_[i];
      gap_ += mu;
    });
  }

  /// A limit is kept by more than its slack where the tangent was the stricter one: then it has that slack.
  double update_slacks() {
    double worst = 0;
    gap_ = 0;
    each_limit([&](std::size_t i, double room, double scale) {
      slacks_[i] = std::max(slacks_[i], room);
      worst = std::max(worst, -room / scale);
      gap_ += slacks_[i] * prices_[i];
    });
    return worst;
  }

  /// Gradient and second derivative of one span's part.
  void span_sums(std::size_t k, double mu, Sums& sums) const {
    const Span& s = spans_[k];
    const double* c = &c_[k];
    const Parts at = parts(k);
    const double left = at[1].b, right = at[3].b;
    // h/6 (1/vl + 4/vm + 1/vr)
    for (const auto& [kind, e, weight] : {std::tuple{1, &s.left, 1.0}, {2, &s.middle, 4.0}, {3, &s.right, 1.0}}) {
      const Part& p = at[static_cast<std::size_t>(kind)];
      const double t = weight / 6 * s.length * p.bound / p.b;
      sums.add(*e, -0.5 * t, 0.75 * t / p.b);
    }

    struct Shared {
      double first = 0, second = 0, prices = 0;
      Local mixed{};
    };
    std::array<Shared, 4> shared;
    for (std::size_t r = s.first_row; r < s.end_row; ++r) {
      const Row& row = rows_[r];
      const auto kind = static_cast<std::size_t>(row.kind);
      const double l = dot(row.g, c), b = at[kind].bound;
      const double zu = prices_[2 * r], su = slacks_[2 * r], zd = prices_[2 * r + 1], sd = slacks_[2 * r + 1];
      const double wu = zu / su, wd = zd / sd;
      // pull of a limit along its gradient: mu/s - z/s (room - s)
      const double pull_u = mu / su - wu * (b - l - su), pull_d = mu / sd - wd * (b + l - sd);
      sums.add(row.g, pull_u - pull_d, wu + wd);
      Shared& x = shared[kind];
      x.first -= pull_u + pull_d, x.second += wu + wd, x.prices += zu + zd;
      for (std::size_t i = 0; i < 3; ++i) x.mixed[i] += (wd - wu) * row.g[i];
    }
    for (const Kind kind : {Kind::Left, Kind::Middle, Kind::Right}) {
      const Part& p = at[static_cast<std::size_t>(kind)];
      const Shared& x = shared[static_cast<std::size_t>(kind)];
      const Local& e = place(s, kind);
      const double bent = full_ ? -0.75 * p.bound / (p.b * p.b) * x.prices : 0;
      sums.add(e, x.first * p.slope, x.second * p.slope * p.slope + bent);
      sums.add_mixed(x.mixed, e, p.slope);
    }
    const auto add_cap = [&](std::size_t node, const Local& e, double cap) {
      const double z = prices_[cap_of(node)], slack = slacks_[cap_of(node)];
      const double pull = mu / slack - z / slack * (cap_room(node) - slack);
      sums.add(e, pull / cap, z / slack / (cap * cap));
    };
    add_cap(k, s.left, s.cap);
    if (k + 1 == n_) {
      add_cap(n_, s.right, last_cap_);
      rest_time(p_.cells.back().length, right, s.right, sums);
    }
    if (k == 0 && from_rest_) rest_time(p_.cells.front().length, left, s.left, sums);
  }

  // 3 s / sqrt(b)
  static void rest_time(double length, double b, const Local& e, Sums& sums) {
    const double t = 3 * length / std::sqrt(b);
    sums.add(e, -0.5 * t / b, 0.75 * t / (b * b));
  }

  /// One step. Returns its size, up to 1; 0 where none is possible.
  double step(double mu) {
    full_ = true;
    if (!direction(mu)) {
      full_ = false;
      if (!direction(mu)) return 0;
    }
    const std::size_t n = n_ + 2;
    if (from_rest_) step_[0] = fold_first_ * step_[1];
    step_[n - 1] = fold_last_ * step_[n - 2];

    // How slacks and prices change, and how far that can go.
    double size = 1, price_size = 1;
    slack_step_.assign(prices_.size(), 0), price_step_.assign(prices_.size(), 0);
    const auto limit = [&](std::size_t i, double room, double change) {
      const double s = slacks_[i], z = prices_[i], ds = change + room - s, dz = (mu - z * ds) / s - z;
      slack_step_[i] = ds, price_step_[i] = dz;
      if (ds < 0) size = std::min(size, -kNearly * s / ds);
      if (dz < 0) price_size = std::min(price_size, -kNearly * z / dz);
    };
    for (std::size_t k = 0; k < n_; ++k) {
      const Span& s = spans_[k];
      const Parts at = parts(k);
      std::array<double, 4> change{};
      for (const Kind kind : {Kind::Left, Kind::Middle, Kind::Right}) {
        const auto i = static_cast<std::size_t>(kind);
        const double db = dot(place(s, kind), &step_[k]);
        change[i] = at[i].slope * db;
        if (db < 0) size = std::min(size, -0.8 * at[i].b / db);
      }
      for (std::size_t r = s.first_row; r < s.end_row; ++r) {
        const auto i = static_cast<std::size_t>(rows_[r].kind);
        const double l = dot(rows_[r].g, &c_[k]), dl = dot(rows_[r].g, &step_[k]);
        limit(2 * r, at[i].bound - l, change[i] - dl);
        limit(2 * r + 1, at[i].bound + l, change[i] + dl);
      }
      limit(cap_of(k), cap_room(k), -dot(s.left, &step_[k]) / s.cap);
    }
    limit(cap_of(n_), cap_room(n_), -dot(spans_[n_ - 1].right, &step_[n_ - 1]) / last_cap_);

    for (std::size_t i = 0; i < n; ++i) c_[i] += size * step_[i];
    for (std::size_t i = 0; i < prices_.size(); ++i) {
      slacks_[i] += size * slack_step_[i];
      prices_[i] += price_size * price_step_[i];
    }
    return size;
  }

  /// Newton's direction for b; false where the second derivative is not positive.
  bool direction(double mu) {
    const std::size_t n = n_ + 2;
    gradient_.assign(n, 0), d0_.assign(n, 0), d1_.assign(n, 0), d2_.assign(n, 0);
    for (std::size_t k = 0; k < n_; ++k) {
      Sums sums;
      span_sums(k, mu, sums);
      for (std::size_t i = 0; i < 3; ++i) gradient_[k + i] += sums.gradient[i], d0_[k + i] += sums.second[i][i];
      d1_[k] += sums.second[0][1], d1_[k + 1] += sums.second[1][2], d2_[k] += sums.second[0][2];
    }
    bind_ends();
    return solve_band();
  }

  // c0 = fold c1 (from rest), c[n-1] = fold c[n-2]: their rows go into those of the free ones.
  void bind_ends() {
    const std::size_t n = n_ + 2;
    const auto alone = [&](std::size_t i) { gradient_[i] = 0, d0_[i] = 1; };
    if (from_rest_) {
      const double f = fold_first_;
      gradient_[1] += f * gradient_[0];
      d0_[1] += f * (2 * d1_[0] + f * d0_[0]);
      d1_[1] += f * d2_[0];
      d1_[0] = d2_[0] = 0;
      alone(0);
    }
    const double f = fold_last_;
    gradient_[n - 2] += f * gradient_[n - 1];
    d0_[n - 2] += f * (2 * d1_[n - 2] + f * d0_[n - 1]);
    d1_[n - 3] += f * d2_[n - 3];
    d1_[n - 2] = d2_[n - 3] = 0;
    alone(n - 1);
  }

  /// L D L' of the band matrix, step = -H^-1 gradient.
  bool solve_band() {
    const std::size_t n = n_ + 2;
    step_.resize(n);
    for (std::size_t i = 0; i < n; ++i) {
      if (i >= 1) {
        const double l1 = d1_[i - 1];  // D L of the row before
        d0_[i] -= l1 * l1 / d0_[i - 1];
        if (i + 1 < n) d1_[i] -= l1 * d2_[i - 1] / d0_[i - 1];
      }
      if (i >= 2) d0_[i] -= d2_[i - 2] * d2_[i - 2] / d0_[i - 2];
      if (!(d0_[i] > 0)) {
        if (full_) return false;
        d0_[i] = std::numeric_limits<double>::infinity();
      }
      double y = -gradient_[i];
      if (i >= 1) y -= d1_[i - 1] / d0_[i - 1] * step_[i - 1];
      if (i >= 2) y -= d2_[i - 2] / d0_[i - 2] * step_[i - 2];
      step_[i] = y;
    }
    for (std::size_t i = n; i-- > 0;) {
      double x = step_[i];
      if (i + 1 < n) x -= d1_[i] * step_[i + 1];
      if (i + 2 < n) x -= d2_[i] * step_[i + 2];
      step_[i] = x / d0_[i];
    }
    return true;
  }

  [[nodiscard]] std::vector<PaceNode> nodes(const std::vector<double>& c) const {
    std::vector<PaceNode> out;
    if (from_rest_) out.push_back({0, 0});
    for (std::size_t k = 0; k < n_; ++k) {
      const Span& s = spans_[k];
      const auto i = static_cast<std::ptrdiff_t>(k);
      out.push_back({std::sqrt(dot(s.left, &c[k])), 0.5 * (c[k + 1] - c[k]) / (before(i) + after(i))});
    }
    const double last = dot(spans_[n_ - 1].right, &c[n_ - 1]);
    out.push_back({std::sqrt(last), -2.0 / 3 * last / p_.cells.back().length});
    out.push_back({0, 0});
    return out;
  }

  const PaceProblem& p_;
  std::vector<PaceCell> cells_;
  bool from_rest_ = true;
  std::size_t first_ = 0, end_ = 0, n_ = 0;
  std::vector<Span> spans_;
  std::vector<Row> rows_;
  double last_cap_ = 0, fold_first_ = 0, fold_last_ = 0;
  bool full_ = false;
  double share_ = 1;
  double gap_ = 0;  ///< sum of slack times price
  std::vector<double> c_, step_, gradient_, d0_, d1_, d2_;
  std::vector<double> slacks_, prices_, slack_step_, price_step_;
};

}  // namespace

Pace fastest(const PaceProblem& problem, const Pace* near) {
  if (problem.cells.size() < 4) return {};
  return Solver(problem).solve(near);
}

}  // namespace gantry::motion
