#include "tests/motion/plan/plan_trial.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>

#include "motion/plan/certificate.hpp"
#include "motion/plan/lift_over.hpp"
#include "motion/plan/random_tree.hpp"
#include "motion/plan/search_path.hpp"
#include "motion/plan/verify.hpp"
#include "tests/motion/plan/prism_distance.hpp"
#include "tests/motion/plan/random_bodies.hpp"
#include "tests/motion/plan/world_judge.hpp"

namespace gantry::test {
namespace {

using config::Machine;
using motion::Scene;

Machine space(Vec3 high) {
  Machine m;
  const char* const names[] = {"X", "Y", "Z"};
  for (std::uint8_t i = 0; i < 3; ++i) {
    config::Axis a;
    a.id = AxisId{i}, a.name = names[i], a.p_min = -1000, a.p_max = i == 0 ? high.x : i == 1 ? high.y : high.z;
    m.axes.push_back(a);
  }
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  return m;
}
AxisVec axes(Vec3 p) { return {p.x, p.y, p.z}; }
Vec3 tip(const AxisVec& q) { return {q[0], q[1], q[2]}; }

/// Of any size; some are foils, some needles.
Body some_body(RandomBodies& random, double span, bool grid) {
  Body b = random.body(span, grid);
  const int form = random.whole(0, 9);
  if (form == 0 && b.shape.kind == Kind::Box) b.shape.size.x = 0.05;
  if (form == 1 && b.shape.kind == Kind::Box) b.shape.size.z = 0.05;
  if (form == 2 && b.shape.kind != Kind::Box) b.shape.size.x = b.shape.size.y = 0.2;
  if (b.shape.kind == Kind::Capsule) b.shape.size.z = std::max(b.shape.size.z, b.shape.size.x);
  return b;
}

/// Walks along a line by what is left to the nearest body: never past a collision that is deeper than `step_mm`.
bool judged_free(const Machine& m, Vec3 from, Vec3 to, double clearance_mm) {
  constexpr double kStep_mm = 0.005;
  const double length = norm(to - from);
  for (double at = 0;;) {
    const Vec3 p = length > 0 ? from + (to - from) * (at / length) : from;
    double least = 1e9;
    for (Body a : m.head) {
      a.centre = a.centre + p;
      for (const Body& b : m.scene) least = std::min(least, distance(a, b));
    }
    if (least <= clearance_mm) return false;
    if (at >= length) return true;
    at = std::min(length, at + std::max(kStep_mm, least - clearance_mm));
  }
}

constexpr double kSure_mm = 1e-6;  // a contact that is deeper is one for every judge

/// Whether a body of the head, smaller all around by `kSure_mm`, still meets something.
bool overlaps(const Machine& m, Vec3 tip) {
  for (Body a : m.head) {
    a.centre = a.centre + tip;
    a.shape.size = a.shape.size - Vec3{2 * kSure_mm, 2 * kSure_mm, 2 * kSure_mm};
    if (std::any_of(m.scene.begin(), m.scene.end(), [&](const Body& b) { return distance(a, b) <= 0; })) return true;
  }
  return false;
}

struct Pallet {
  Machine machine;                ///< as the planner is told
  std::vector<sim::Solid> truly;  ///< as it stands
};

/// A pallet of one of several kinds, some with walls that have slots, some closed altogether; some boxes lean, some
/// parts stand in a row without a gap.
Pallet random_pallet(RandomBodies& random) {
  Machine m = space({120, 90, 40});
  for (auto& a : m.axes) a.p_min = 0;
  const bool grid = random.whole(0, 2) == 0;
  m.clearance_mm = random.whole(0, 2) == 0 ? 0 : grid ? 0.5 : random.real(0.05, 1.5);
  m.head = {{"needle", {Kind::Capsule, {0.2, 0.2, 12}}, {0, 0, 6}, 0, false}};
  if (random.whole(0, 1) == 0) m.head.push_back({"syringe", {Kind::Cylinder, {8, 8, 30}}, {0, 0, 27}, 0, false});
  if (random.whole(0, 2) == 0) m.head.push_back({"camera", {Kind::Box, {10, 12, 20}}, {14, 0, 30}, 0.2, false});
  const int count = random.whole(3, 40);
  for (int i = 0; i < count; ++i) {
    Body b = some_body(random, 1, grid);
    b.centre = grid ? Vec3{10.0 * random.whole(0, 12), 10.0 * random.whole(0, 9), 2.0 * random.whole(0, 8)}
                    : Vec3{random.real(0, 120), random.real(0, 90), random.real(0, 18)};
    m.scene.push_back(b);
  }
  if (random.whole(0, 1) == 0) {  // a wall up to beyond the top, with a slot or without
    const double x = random.real(30, 90), y = random.real(10, 80), slot = random.whole(0, 2) * random.real(0.4, 3);
    const double thick = random.whole(0, 1) == 0 ? 0.05 : random.real(1, 10);
    m.scene.push_back({"", {Kind::Box, {thick, 200, 200}}, {x, y - 100, 40}, 0, false});
    m.scene.push_back({"", {Kind::Box, {thick, 200, 200}}, {x, y + 100 + slot, 40}, 0, false});
  }
  if (random.whole(0, 3) == 0) {  // bricks
    const Vec3 size{random.real(3, 12), random.real(3, 12), random.real(2, 16)};
    const double turn = grid ? 0 : random.real(-4, 4);
    const Vec2 at{random.real(20, 100), random.real(20, 70)}, on{std::cos(turn) * size.x, std::sin(turn) * size.x};
    for (int i = 0; i < 4; ++i)
      m.scene.push_back({"", {Kind::Box, size}, {at.x + i * on.x, at.y + i * on.y, size.z / 2}, turn, false});
  }
  std::vector<sim::Solid> truly;
  for (std::size_t i = 0; i < m.scene.size(); ++i) {
    m.scene[i].name = "part " + std::to_string(i);
    const bool leans = m.scene[i].shape.kind == Kind::Box && m.scene[i].shape.size.x < 20 && random.whole(0, 7) == 0;
    const Stands s =
        leans ? leaning(m.scene[i], {random.real(-0.4, 0.4), random.real(-0.4, 0.4)}) : upright(m.scene[i]);
    m.scene[i] = s.told;
    truly.push_back(s.truly);
  }
  return {std::move(m), std::move(truly)};
}

}  // namespace

PairTally try_pairs(int count, std::uint64_t seed) {
  RandomBodies random(seed);
  PairTally tally;
  for (int i = 0; i < count; ++i) {
    const bool grid = i % 2 == 0;
    Machine m = space({1000, 1000, 1000});
    m.head = {some_body(random, 14, grid)}, m.scene = {some_body(random, 14, grid)};
    const Vec3 from = random.step(40, grid), step = random.whole(0, 20) == 0 ? Vec3{} : random.step(30, grid);
    Body start = m.head.front();
    start.centre = start.centre + from;
    const double truth = swept_distance(start, step, m.scene.front());
    double margin = grid ? 0.5 * random.whole(0, 4) : random.real(0, 3);
    if (i % 4 == 1 && truth > 1e-3)
      margin = truth - random.whole(-1, 1) * std::pow(10.0, random.whole(-10, -6)) * random.real(0.5, 2);
    const Scene scene(m);
    const AxisVec a = axes(from), b = axes(from + step);
    const motion::Margins margins{std::max(0.0, margin), {}};
    motion::Proof proof;
    const bool free = motion::is_clear(scene, a, b, margins);
    const bool hit = motion::first_hit(scene, a, b, margins, &proof).has_value();
    if (free == hit || (free && !motion::is_free(scene, a, b, proof, margins))) ++tally.disagreements;
    const double room = truth - margins.clearance_mm;
    ++(free ? tally.free : tally.hit);
    if (free && room <= 1e-9) ++tally.false_free;
    if (!free && room > 1e-6) ++tally.false_hits;
    if (!free && room > 1e-9 && room <= 1e-6) ++tally.close_calls;
    if ((free && room <= 1e-9) || (!free && room > 1e-6))
      std::printf("pair %d of seed %llu: called %s, room %.3e mm\n", i, static_cast<unsigned long long>(seed),
                  free ? "free" : "hit", room);
  }
  return tally;
}

PlanTally try_plans(int count, std::uint64_t seed) {
  RandomBodies random(seed);
  PlanTally tally;
  for (int i = 0; i < count; ++i) {
    const Pallet pallet = random_pallet(random);
    const Machine& m = pallet.machine;
    const Scene scene(m);
    const motion::Margins margins{m.clearance_mm, {}};
    const auto somewhere = [&] { return Vec3{random.real(0, 120), random.real(0, 90), random.real(0, 25)}; };
    const Vec3 from = somewhere(), to = somewhere();
    const auto found = motion::search_path(scene, axes(from), axes(to), margins);
    if (i % 16 == 0 && motion::search_path(scene, axes(from), axes(to), margins).points != found.points)
      ++tally.different;
    const auto complain = [&](int& of, const char* what) {
      ++of;
      std::printf("plan %d of seed %llu: %s\n", i, static_cast<unsigned long long>(seed), what);
    };
    using Status = motion::SearchStatus;
    if (found.status == Status::Ok) {
      ++tally.ok;
      if (!motion::certify(scene, found.points, {.clearance_mm = m.clearance_mm, .approaches = {}}))
        complain(tally.refused, "refused by the second check");
      for (std::size_t k = 0; k + 1 < found.points.size(); ++k)
        if (!judged_free(m, tip(found.points[k]), tip(found.points[k + 1]), m.clearance_mm)) {
          complain(tally.colliding, "collides");
          break;
        }
      if (WorldJudge(m, pallet.truly).collides(found.points)) complain(tally.in_world, "the world sees a collision");
      if (const auto over = motion::lift_over(scene, axes(from), axes(to), margins)) {
        double length = 0;
        for (std::size_t k = 0; k + 1 < over->points.size(); ++k)
          length += norm(tip(over->points[k + 1]) - tip(over->points[k]));
        if (found.length_mm > length + 1e-9) complain(tally.longer, "longer than the lift-over");
      }
    } else if (found.status == Status::NoPath) {
      ++tally.no_path;
      const auto clear = [&](Vec3 a, Vec3 b) { return judged_free(m, a, b, m.clearance_mm); };
      if (i % 8 == 0 && !motion::random_tree(clear, {0, 0, 0}, {120, 90, 40}, from, to, seed, 300).empty())
        complain(tally.disproved, "there is a path");
    } else {
      ++(found.status == Status::Budget ? tally.budget : tally.taken);
      const Vec3 end = found.status == Status::StartCollides ? from : to;
      if (found.hit && overlaps(m, end)) {
        std::vector<sim::Solid> told;
        for (const Body& b : m.scene) told.push_back(upright(b).truly);
        Machine touching = m;
        touching.clearance_mm = 0;
        const std::array<AxisVec, 1> at{axes(end)};
        if (!WorldJudge(touching, told).collides(at)) complain(tally.unseen, "the world sees no collision at an end");
      }
      if (found.status == Status::Budget) std::printf("plan %d: budget\n", i);
    }
  }
  return tally;
}

}  // namespace gantry::test
