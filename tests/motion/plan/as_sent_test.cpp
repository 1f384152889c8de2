// Targets that are sent to axes of unlike delay: judged by closed-form distances at thousands of moments and rates, by
// an integration of the line's phases of its own.
#include "motion/plan/as_sent.hpp"

#include <cmath>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

constexpr std::uint64_t kSeed = 20261126;
constexpr double kJerk = 60000, kRise_s = 0.05;  // 3000 mm/s^2 after 50 ms

Limits limits_with(const AxisVec& delay_s) {
  Limits limits;
  limits.axes = 5;
  for (AxisLimits& axis : limits.axis) axis = {-1000, 1000, 600, kJerk * kRise_s, kJerk};
  limits.response_delay_s = delay_s;
  return limits;
}

/// From rest to rest along a unit direction of X Y Z: `hold_s` at 3000 mm/s^2, `cruise_s` at full speed.
struct Line {
  AxisVec from{}, u{};
  double hold_s = 0, cruise_s = 0;

  [[nodiscard]] std::vector<Phase> phases() const {
    return {{kRise_s, kJerk},  {hold_s, 0}, {kRise_s, -kJerk}, {cruise_s, 0},
            {kRise_s, -kJerk}, {hold_s, 0}, {kRise_s, kJerk}};
  }
  [[nodiscard]] double duration() const { return 4 * kRise_s + 2 * hold_s + cruise_s; }
  [[nodiscard]] double s(double t) const {
    double s = 0, v = 0, a = 0;
    for (const Phase& p : phases()) {
      const double dt = std::clamp(t, 0.0, p.duration_s);
      s += v * dt + a * dt * dt / 2 + p.jerk * dt * dt * dt / 6;
      v += a * dt + p.jerk * dt * dt / 2, a += p.jerk * dt;
      t -= p.duration_s;
    }
    return s;
  }
  [[nodiscard]] Segment segment() const {
    const double length = s(duration());
    AxisVec displacement{};
    for (std::size_t i = 0; i < u.size(); ++i) displacement[i] = u[i] * length;
    Segment out;
    out.geometry = straight(from, displacement, length);
    for (const Phase& p : phases()) out.nominal.phases.push_back(p);
    out.v_cap = kJerk * kRise_s * (kRise_s + hold_s);
    return out;
  }
  /// At a rate r of the plan the delays are r times as long in planned time.
  [[nodiscard]] AxisVec sent(double t, double rate, const AxisVec& delay_s, double middle_s) const {
    AxisVec q = from;
    for (std::size_t i = 0; i < q.size(); ++i) q[i] += u[i] * s(t + rate * (delay_s[i] - middle_s));
    return q;
  }
};

Line random_line(test::RandomBodies& random) {
  Line out;
  const int moving = random.whole(1, 7);
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if ((moving >> i & 1) != 0) out.u[i] = random.real(-1, 1);
    square += out.u[i] * out.u[i];
  }
  for (std::size_t i = 0; i < 3; ++i) out.u[i] /= std::sqrt(square);
  for (std::size_t i = 0; i < 3; ++i) out.from[i] = random.real(-20, 20);
  out.hold_s = random.real(0, 0.1), out.cruise_s = random.real(0, 0.05);
  return out;
}

double distance_at(const config::Machine& m, const std::vector<config::Body>& standing, const AxisVec& q) {
  double best = 1e9;
  for (config::Body head : m.head) {
    head.centre = head.centre + Vec3{q[0], q[1], q[2] - (head.on_lift ? q[4] : 0)};
    for (const config::Body& b : standing) best = std::min(best, test::distance(head, b));
  }
  return best;
}

TEST(AsSent, what_is_called_free_keeps_the_clearance_at_every_moment_and_rate) {
  test::RandomBodies random(kSeed);
  const config::Machine machine = test::bare_machine();
  constexpr double kRounding_mm = 1e-6, kTooStrict_mm = 0.08;
  constexpr double kClearance_mm = 2;
  int free = 0, blocked_by_delays = 0;
  for (int n = 0; n < 200; ++n) {
    const AxisVec delay_s{0.001 * random.real(1, 9), 0.001 * random.real(1, 9), 0.001 * random.real(1, 9), 0.002,
                          0.002};
    const Limits limits = limits_with(delay_s);
    const Line line = random_line(random);
    // The first body stands so near to the line that the delays decide; the others stand anywhere.
    std::vector<config::Body> standing;
    const AxisVec near = line.sent(line.duration() * random.real(0.2, 0.8), 0, delay_s, 0);
    for (int k = 0; k < 200 && standing.empty(); ++k) {
      config::Body body = random.body(30, false);
      body.centre = body.centre + Vec3{near[0], near[1], near[2]};
      double along = 1e9;
      for (double t = 0; t < line.duration(); t += 0.002)
        along = std::min(along, distance_at(machine, {body}, line.sent(t, 0, delay_s, 0)));
      if (along > kClearance_mm && along < kClearance_mm + 0.5) standing.push_back(body);
    }
    if (standing.empty()) continue;
    Scene scene(machine);
    scene.add(standing);
    const std::vector<Segment> motion{line.segment()};
    const AsSent sent(scene, limits, motion);
    const auto verdict = sent.certify(0, sent.duration_s(), {kClearance_mm, {}});

    const auto [least, most] = [&] {
      double low = 1e9, high = 0;
      for (std::size_t i = 0; i < 3; ++i)
        if (line.u[i] != 0) low = std::min(low, delay_s[i]), high = std::max(high, delay_s[i]);
      return std::pair(low, high);
    }();
    const double middle_s = (least + most) / 2;
    double nearest = 1e9, planned = 1e9;
    for (double t = -0.005; t < line.duration() + 0.005; t += 0.0005)
      for (const double rate : {0.0, 0.5, 1.0}) {
        const double d = distance_at(machine, standing, line.sent(t, rate, delay_s, middle_s));
        nearest = std::min(nearest, d);
        if (rate == 0) planned = std::min(planned, d);
      }
    if (verdict) {
      ++free;
      EXPECT_GE(nearest, kClearance_mm - kRounding_mm) << "case " << n;
    } else {
      EXPECT_EQ(verdict.error().fault, Fault::Collision);
      EXPECT_LT(nearest, kClearance_mm + kTooStrict_mm) << "case " << n << ": " << to_text(verdict.error());
      blocked_by_delays += planned > kClearance_mm + kTooStrict_mm ? 1 : 0;
    }
    const double length = line.s(line.duration());
    double off = 0;
    for (double t = 0; t < line.duration(); t += 0.001) {
      AxisVec q = line.sent(t, 1, delay_s, middle_s);
      double along = 0, square = 0;
      for (std::size_t i = 0; i < 3; ++i) q[i] -= line.from[i], along += q[i] * line.u[i];
      along = std::clamp(along, 0.0, length);
      for (std::size_t i = 0; i < 3; ++i) square += (q[i] - along * line.u[i]) * (q[i] - along * line.u[i]);
      off = std::max(off, std::sqrt(square));
    }
    const double bound = beside_line_mm(limits, motion.front());
    EXPECT_LE(off, bound + kRounding_mm);
    if (line.cruise_s > most - least) {
      EXPECT_GE(off, bound * 0.999 - kRounding_mm);
    }
  }
  EXPECT_GT(free, 50);
  EXPECT_GT(blocked_by_delays, 5);
}

TEST(AsSent, axes_that_answer_alike_or_move_alone_are_sent_along_the_path) {
  const Scene scene(test::bare_machine());
  const std::vector<Segment> up{Line{{}, {0, 0, 1}, 0.05, 0.05}.segment()};
  const std::vector<Segment> slanted{Line{{}, {0.6, 0, 0.8}, 0.05, 0.05}.segment()};
  EXPECT_FALSE(AsSent(scene, limits_with({0.003, 0.009, 0.005}), up).beside_path());
  EXPECT_FALSE(AsSent(scene, limits_with({0.004, 0.009, 0.004}), slanted).beside_path());
  EXPECT_TRUE(AsSent(scene, limits_with({0.003, 0.003, 0.005}), slanted).beside_path());
}

/// Up by one axis alone, then slanted: while Z alone moves its targets are on the path to the last bit, however unlike
/// the delays, so that nothing is asked of them beyond what the path's own proof has asked. Slanted at once, the same
/// body is met.
TEST(AsSent, one_axis_alone_keeps_the_very_clearance_in_a_motion_that_goes_on_slanted) {
  const config::Machine machine = test::bare_machine();
  const Line up{{0, 0, 20}, {0, 0, 1}, 0.05, 0.05};
  const AxisVec above = up.sent(1e9, 0, {}, 0);
  const Line slanted{above, {0.6, 0.8, 0}, 0.05, 0.05};
  const std::vector<Segment> motion{up.segment(), slanted.segment()};
  const Limits limits = limits_with({0.009, 0.001, 0.005});
  // Beside the needle's lower end at the start, on the side to which nothing goes; no other body comes so low.
  const double needle_mm = 0.5, post_mm = 1, clearance_mm = 2;
  for (const double nearer_mm : {-1e-6, 0.0, 1e-6}) {
    const double off = needle_mm + post_mm + clearance_mm - nearer_mm;
    Scene scene(machine);
    scene.add(config::Body{"post", {config::Shape::Kind::Cylinder, {2, 2, 10}}, {-off * 0.8, off * 0.6, 18}, 0, false});
    const AsSent sent(scene, limits, motion);
    ASSERT_TRUE(sent.beside_path());
    const auto path = certify(scene, std::array{up.from, above, slanted.sent(1e9, 0, {}, 0)}, {clearance_mm, {}});
    const auto verdict = sent.certify(0, sent.duration_s(), {clearance_mm, {}});
    EXPECT_TRUE(verdict) << nearer_mm << ": " << to_text(verdict.error());
    if (nearer_mm < 0) {
      EXPECT_TRUE(path) << to_text(path.error());
    }
    if (nearer_mm > 1e-7) {
      EXPECT_FALSE(path);
    }
    const std::vector<Segment> at_once{Line{up.from, {0.6, 0.8, 0}, 0.05, 0.05}.segment()};
    Scene beside(machine);
    beside.add(config::Body{"post",
                            {config::Shape::Kind::Cylinder, {2, 2, 10}},
                            {-off * 0.8 + 0.6 * 9, off * 0.6 + 0.8 * 9, 18},
                            0,
                            false});
    const AsSent slanted_at_once(beside, limits, at_once);
    EXPECT_FALSE(slanted_at_once.certify(0, slanted_at_once.duration_s(), {clearance_mm, {}}));
  }
}

TEST(AsSent, a_body_that_the_path_passes_and_the_targets_do_not_is_named) {
  // 300 mm/s at 45 degrees; X answers 4 ms later than Y and is sent so much ahead: 0.85 mm beside the line.
  const config::Machine machine = test::bare_machine();
  const double v = kJerk * kRise_s * (kRise_s + 0.05);
  const double r = 1 / std::sqrt(2.0);
  const Line line{{0, 0, 40}, {r, r, 0}, 0.05, 0.1};
  const std::vector<Segment> motion{line.segment()};
  const Limits limits = limits_with({0.008, 0.004, 0.004});
  EXPECT_NEAR(beside_line_mm(limits, motion.front()), v * 0.004 / 2, 1e-9);
  const double length = line.s(line.duration());
  const Vec2 middle{length / 2 * r, length / 2 * r};
  // A post beside the needle, below everything else: on the side where X is ahead, 2.4 mm from the needle's skin.
  const auto post = [&](double side) {
    const double off = side * (0.5 + 1 + 2.4);
    return config::Body{
        "post", {config::Shape::Kind::Cylinder, {2, 2, 10}}, {middle.x + off * r, middle.y - off * r, 42}, 0, false};
  };
  for (const double side : {1.0, -1.0}) {
    Scene scene(machine);
    scene.add(post(side));
    const AsSent sent(scene, limits, motion);
    const auto verdict = sent.certify(0, sent.duration_s(), {2, {}});
    // The lag that all axes have in common takes no part: what is ahead on one side is behind on no other.
    if (side > 0) {
      ASSERT_FALSE(verdict);
      EXPECT_NE(verdict.error().message.find("needle comes within 2 mm of post"), std::string::npos)
          << verdict.error().message;
      EXPECT_NE(verdict.error().message.find("response_delay"), std::string::npos);
      ASSERT_TRUE(verdict.error().meeting);
      EXPECT_TRUE(sent.certify(0, sent.duration_s(), {2, {{"needle", "post", 0}}})) << "held to the path alone";
    } else {
      EXPECT_TRUE(verdict) << verdict.error().message;
    }
    EXPECT_TRUE(certify(scene, std::array{line.from, line.sent(1e9, 0, {}, 0)}, {2, {}})) << "the path itself is free";
  }
}

}  // namespace
}  // namespace gantry::motion
