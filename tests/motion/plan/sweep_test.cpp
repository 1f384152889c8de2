// A head among bodies: no "free" that sampling contradicts, first contacts where they are, and a second check that is
// not fooled.
#include "motion/plan/sweep.hpp"

#include <chrono>
#include <gtest/gtest.h>

#include "motion/plan/verify.hpp"
#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"

namespace gantry::motion {
namespace {

using test::at;
constexpr std::uint64_t kSeed = 99;

/// A pallet of parts below the head's paths and among them.
std::vector<config::Body> pallet(test::RandomBodies& random, int count, bool grid) {
  std::vector<config::Body> out;
  for (int i = 0; i < count; ++i) {
    config::Body b = random.body(1, grid);
    b.name = "part " + std::to_string(i);
    b.centre = grid ? Vec3{10.0 * random.whole(0, 40), 10.0 * random.whole(0, 30), 1.0 * random.whole(0, 20)}
                    : Vec3{random.real(0, 400), random.real(0, 300), random.real(0, 20)};
    out.push_back(b);
  }
  return out;
}
AxisVec somewhere(test::RandomBodies& random, bool grid) {
  if (grid) return at(5.0 * random.whole(0, 80), 5.0 * random.whole(0, 60), random.whole(0, 40), random.whole(0, 15));
  return at(random.real(0, 400), random.real(0, 300), random.real(0, 40), random.real(0, 15));
}
/// Least distance of all pairs on the motion, by closed forms.
double judged(const config::Machine& m, const std::vector<config::Body>& parts, const AxisVec& from,
              const AxisVec& to) {
  double best = 1e9;
  for (config::Body a : m.head) {
    const auto carried = [&](const AxisVec& q) { return Vec3{q[0], q[1], q[2] - (a.on_lift ? q[4] : 0)}; };
    const Vec3 d = carried(to) - carried(from);
    a.centre = a.centre + carried(from);
    for (const config::Body& b : parts) best = std::min(best, test::swept_distance(a, d, b));
  }
  return best;
}

TEST(Sweep, free_and_hit_are_what_closed_forms_say) {
  test::RandomBodies random(kSeed);
  const config::Machine machine = test::bare_machine();
  int free = 0, hits = 0;
  for (int i = 0; i < 600; ++i) {
    const bool grid = i % 2 == 0;
    const auto parts = pallet(random, 30, grid);
    Scene scene(machine);
    for (const config::Body& p : parts) scene.add(p);
    const AxisVec from = somewhere(random, grid), to = somewhere(random, grid);
    const double margin = grid ? random.whole(0, 3) : random.real(0, 3), truth = judged(machine, parts, from, to);
    Proof proof;
    const auto hit = first_hit(scene, from, to, {margin, {}}, &proof);
    ASSERT_EQ(is_clear(scene, from, to, {margin, {}}), !hit) << "case " << i << " seed " << kSeed;
    if (hit) {
      ++hits;
      ASSERT_LT(truth, margin + 1e-6) << "case " << i << " seed " << kSeed;
    } else {
      ++free;
      ASSERT_GT(truth, margin - 1e-9) << "case " << i << " seed " << kSeed;
      ASSERT_TRUE(is_free(scene, from, to, proof, {margin, {}})) << "case " << i;
    }
  }
  EXPECT_GT(free, 100);
  EXPECT_GT(hits, 100);
}

TEST(Sweep, tells_the_first_contact_its_bodies_and_its_point) {
  test::RandomBodies random(kSeed + 1);
  const config::Machine machine = test::bare_machine();
  int seen = 0;
  for (int i = 0; i < 600; ++i) {
    const auto parts = pallet(random, 40, i % 2 == 0);
    Scene scene(machine);
    for (const config::Body& p : parts) scene.add(p);
    const AxisVec from = somewhere(random, false), to = somewhere(random, false);
    const auto hit = first_hit(scene, from, to, {1.5, {}});
    if (!hit || judged(machine, parts, from, from) < 1.5) continue;
    ++seen;
    AxisVec there{};
    for (std::size_t k = 0; k < 5; ++k) there[k] = from[k] + (to[k] - from[k]) * hit->fraction;
    EXPECT_NEAR(judged(machine, parts, there, there), 1.5, 2e-3) << "case " << i;
    EXPECT_GT(judged(machine, parts, from, there), 1.5 - 1e-9) << "case " << i;
    config::Body a = machine.head[hit->head];
    a.centre = a.centre + scene.carried(scene.head()[hit->head], there);
    const config::Body point{"point", {config::Shape::Kind::Box, {}}, hit->point, 0, false};
    EXPECT_NEAR(test::distance(a, point), 1.5, 2e-3) << "case " << i;
    EXPECT_NEAR(test::distance(parts[hit->standing], point), 0, 2e-3) << "case " << i;
  }
  EXPECT_GT(seen, 50);
}

TEST(Sweep, lift_bodies_move_with_z_less_u) {
  Scene scene(test::bare_machine());
  scene.add(test::box("post", {4, 4, 20}, {100, 30, 10}));  // top at 20, under the probe (bottom at 15 + Z - U)
  EXPECT_FALSE(first_hit(scene, at(100, 0, 40), at(100, 0, 40, 15), {2, {}}));
  const auto hit = first_hit(scene, at(100, 0, 18), at(100, 0, 18, 15), {2, {}});
  ASSERT_TRUE(hit);
  EXPECT_EQ(scene.head()[hit->head].name, "probe");
  EXPECT_NEAR(hit->fraction, 11.0 / 15, 1e-4);  // 33 - U = 22
  EXPECT_NEAR(hit->point.z, 20, 1e-3);
  EXPECT_FALSE(first_hit(scene, at(100, 0, 18, 9), at(100, 0, 24, 15), {2, {}}));  // Z and U rise together
}

TEST(Sweep, an_allowed_approach_lets_its_pair_nearer_and_no_other) {
  Scene scene(test::bare_machine());
  scene.add(test::box("board", {120, 80, 2}, {100, 100, 1}));
  const AxisVec low = at(100, 100, 2.3);
  EXPECT_TRUE(first_hit(scene, at(100, 100, 20), low, {2, {}}));
  const auto near = make_margins(scene, 2, {{"needle", "board", 0.28}});
  ASSERT_TRUE(near);
  EXPECT_FALSE(first_hit(scene, at(100, 100, 20), low, *near));
  const auto tight = make_margins(scene, 2, {{"needle", "board", 0.31}});
  const auto hit = first_hit(scene, at(100, 100, 20), low, *tight);
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->point.z, 2, 1e-3);
  const auto press = make_margins(scene, 2, {{"probe", "board", -1.5}});  // probe's bottom at 15 + Z - U
  EXPECT_FALSE(first_hit(scene, at(100, 70, 10), at(100, 70, 6, 20.4), *press));
  EXPECT_TRUE(first_hit(scene, at(100, 70, 10), at(100, 70, 6, 20.6), *press));
  EXPECT_EQ(make_margins(scene, 2, {{"needle", "bord", 0}}).error().fault, Fault::UnknownReference);
}

/// A clip beside the board, lower than its top, is no board.
TEST(Sweep, an_allowed_approach_is_inherited_by_nothing_that_stands_lower) {
  Scene scene(test::bare_machine());
  scene.add(test::box("board", {120, 80, 4}, {100, 100, 2}));
  for (const double top : {1.0, 3.5, 4.0}) {
    Scene with = scene;
    with.add(test::box("clip", {6, 6, top}, {100, 57, top / 2}));
    const auto margins = make_margins(with, 2, {{"needle", "board", 0.2}});
    ASSERT_TRUE(margins);
    const AxisVec low = at(100, 60.5, 4.3);
    EXPECT_FALSE(first_hit(scene, at(100, 60.5, 20), low, *margins));
    const double apart = std::hypot(0.5, 4.8 - top) - 0.5;  // the clip's edge from the centre of the needle's round end
    const auto hit = first_hit(with, at(100, 60.5, 20), low, *margins);
    EXPECT_EQ(hit.has_value(), apart < 2) << top;
    if (hit) {
      EXPECT_EQ(with.standing()[hit->standing].name, "clip");
    }
  }
}

TEST(Verify, refuses_proofs_that_do_not_hold) {
  Scene scene(test::bare_machine());
  scene.add(test::box("post", {10, 10, 30}, {100, 100, 15}));
  const AxisVec from = at(60, 60, 5), to = at(60, 140, 5);
  Proof proof;
  ASSERT_FALSE(first_hit(scene, from, to, {2, {}}, &proof));
  for (Separation p : proof) {
    EXPECT_TRUE(holds(scene, from, to, p, 2));
    EXPECT_FALSE(holds(scene, from, to, p, 200));
    EXPECT_FALSE(holds(scene, from, at(100, 100, 5), p, 2) && p.head == 0);  // another motion
    p.direction = p.direction * -1;
    EXPECT_FALSE(holds(scene, from, to, p, 2));
    p.direction = {0, 0, 0};
    EXPECT_FALSE(holds(scene, from, to, p, -100));
    p.direction = {2, 0, 0};
    EXPECT_FALSE(holds(scene, from, to, p, 2));
  }
}

/// What a proof must not leave out, and what it must not add.
TEST(Verify, misses_no_body_that_a_proof_leaves_out) {
  test::RandomBodies random(kSeed + 3);
  const config::Machine machine = test::bare_machine();
  int proofs = 0;
  for (int i = 0; i < 300; ++i) {
    Scene scene(machine);
    scene.add(pallet(random, 60, i % 2 == 0));
    const AxisVec from = somewhere(random, false), to = somewhere(random, false);
    Proof proof;
    const Margins margins{1, {}};
    if (first_hit(scene, from, to, margins, &proof)) continue;
    ++proofs;
    ASSERT_TRUE(is_free(scene, from, to, proof, margins));
    for (std::size_t k = 0; k < proof.size(); ++k) {
      Proof less = proof;
      less.erase(less.begin() + static_cast<std::ptrdiff_t>(k));
      ASSERT_FALSE(is_free(scene, from, to, less, margins));
    }
    Proof more = proof;
    more.push_back(proof.back());
    ASSERT_FALSE(is_free(scene, from, to, more, margins));
    more = proof;
    if (proof.size() > 1) {
      std::swap(more.front(), more.back());
      ASSERT_FALSE(is_free(scene, from, to, more, margins));
    }
    proof.front().direction = proof.front().direction * -1;
    ASSERT_FALSE(is_free(scene, from, to, proof, margins));
  }
  EXPECT_GT(proofs, 20);
}

/// In single precision, and yet it leaves out nothing that a test in double precision does not leave out.
TEST(WideTree, names_every_body_that_is_near) {
  test::RandomBodies random(kSeed + 5);
  const config::Machine machine = test::bare_machine();
  long named = 0, near = 0;
  for (int i = 0; i < 1000; ++i) {
    auto parts = pallet(random, random.whole(1, 120), i % 2 == 0);
    const double off = i % 3 == 0 ? 0.0 : random.real(-20000, 20000);  // far from the origin numbers are coarser
    for (config::Body& b : parts) b.centre.x += off;
    Scene scene(machine);
    scene.add(parts);
    AxisVec from = somewhere(random, i % 2 == 0), to = somewhere(random, i % 2 == 0);
    from[0] += off, to[0] += off;
    for (std::size_t head = 0; head < machine.head.size(); ++head) {
      const BodySweep body(scene, head, from, to);
      std::vector<bool> seen(parts.size(), false);
      scene.wide_tree().visit(body.question(0.5), [&](std::uint32_t k) {
        EXPECT_FALSE(seen[k]);
        return seen[k] = true;
      });
      for (std::size_t k = 0; k < parts.size(); ++k) {
        const SceneBody& b = scene.standing()[k];
        const bool far = body.far({b.solid.centre, b.half_box}, 0.5);
        ASSERT_TRUE(far || seen[k]) << "case " << i << " seed " << kSeed;
        named += seen[k], near += !far;
      }
    }
  }
  EXPECT_GT(near, 500);
  EXPECT_LT(named, near + near / 20);  // and little else
}

TEST(Verify, refuses_a_tree_that_does_not_hold_its_bodies) {
  test::RandomBodies random(kSeed + 4);
  Scene scene(test::bare_machine());
  scene.add(pallet(random, 40, false));
  EXPECT_TRUE(scene.tree_holds());
  std::vector<SceneBody> bodies = scene.standing();
  EXPECT_TRUE(holds_all(scene.tree(), bodies));
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    std::vector<SceneBody> other = bodies;
    other[i].solid.centre.x += 0.01;  // out of its leaf's box
    EXPECT_FALSE(holds_all(scene.tree(), other));
  }
  bodies.push_back(bodies.back());
  EXPECT_FALSE(holds_all(scene.tree(), bodies)) << "a body is not in the tree";
  bodies.resize(bodies.size() - 2);
  EXPECT_FALSE(holds_all(scene.tree(), bodies)) << "the tree names a body that is not there";
}

TEST(Sweep, tells_what_it_costs) {
  test::RandomBodies random(kSeed);
  Scene scene(test::bare_machine());
  for (const config::Body& p : pallet(random, 200, false)) scene.add(p);
  std::vector<std::pair<AxisVec, AxisVec>> motions;
  for (int i = 0; i < 2000; ++i) motions.emplace_back(somewhere(random, false), somewhere(random, false));
  for (auto& [from, to] : motions) from[2] += 15, to[2] += 15;
  std::array<double, 2> spent_us{};
  std::array<int, 2> count{};
  for (const auto& [from, to] : motions) {
    double best_us = 1e9;
    bool hit = false;
    for (int repeat = 0; repeat < 5; ++repeat) {
      const auto start = std::chrono::steady_clock::now();
      hit = first_hit(scene, from, to, {2, {}}).has_value();
      best_us = std::min(best_us,
                         std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
    }
    ++count[hit], spent_us[hit] += best_us;
  }
  std::printf("among 200 bodies: %d free motions %.2f us each, %d blocked ones %.2f us\n", count[0],
              spent_us[0] / count[0], count[1], spent_us[1] / count[1]);
}

}  // namespace
}  // namespace gantry::motion
