// Jobs that nobody has thought of: random boards, marks, touches, materials and features, on boards that lie at random.
// The world says what lies on them.
#include <fmt/format.h>
#include <random>

#include "recipes/recipe.hpp"
#include "tests/machine/deposits.hpp"

namespace gantry {
namespace {

class Author {
 public:
  explicit Author(std::uint64_t seed) : random_(seed) {}

  std::string recipe() {
    width_ = between(40, 110), depth_ = between(30, 75);
    const int marks = one_of({0, 2, 3, 4}), touches = one_of({0, 1, 2, 3, 4});
    placed_by_marks = marks > 0;
    std::string text = fmt::format(
        "version: 1\nrecipe: random\nplacement: {}\nboard: {{size: [{:.3f} mm, {:.3f} mm], thickness: {:.2f} mm, "
        "frame: "
        "pallet}}\n",
        placed_by_marks ? "marks" : "fixture", width_, depth_, between(1, 20));
    const std::array<Vec2, 4> corners{Vec2{5, 5}, {width_ - 5, depth_ - 5}, {width_ - 5, 5}, {5, depth_ - 5}};
    if (marks > 0) text += "marks:\n";
    for (int i = 0; i < marks; ++i)
      text += fmt::format("  m{}: {{at: {}, diameter: {} mm}}\n", i,
                          point(corners[static_cast<std::size_t>(i)] + Vec2{between(-1, 1), between(-1, 1)}),
                          one_of({1.0, 1.5, 2.0}));
    const std::array<Vec2, 4> probed{Vec2{0.3, 0.3}, {0.7, 0.35}, {0.5, 0.7}, {0.2, 0.8}};
    if (touches > 0) text += "touches:\n";
    for (int i = 0; i < touches; ++i) {
      const Vec2 p = probed[static_cast<std::size_t>(i)];
      text += fmt::format("  t{}: {{at: {}}}\n", i, point({p.x * width_, p.y * depth_}));
    }
    // A board whose tilt is not measured may close a small gap.
    text += "materials:\n";
    for (const char* name : {"a", "b"})
      text += fmt::format(
          "  {}: {{speed: {} mm/s, gap: {} mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: {} ms, "
          "settle_time: {} ms, retract: {} mm, gap_tolerance: {} mm}}\n",
          name, one_of({2, 10, 20, 50, 100}), touches < 3 ? one_of({0.5, 1.0}) : one_of({0.1, 0.2, 0.5, 1.0}),
          one_of({5.0, 33.3, 60.0}), one_of({0, 10, 30}), one_of({0.5, 2.0, 5.0, 10.0}), touches < 3 ? 0.6 : 0.1);
    text += "features:\n";
    const int count = one_of({1, 2, 3, 4, 5, 6});
    for (int i = 0; i < count; ++i) text += feature(i);
    return text;
  }

  std::string placement() {
    if (!placed_by_marks) return "dx=0 mm, dy=0 mm, rot=0 deg";
    return fmt::format("dx={:.3f} mm, dy={:.3f} mm, rot={:.3f} deg", between(-2, 2), between(-2, 2),
                       between(-1.5, 1.5));
  }

  bool placed_by_marks = false;

 private:
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  template <class T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + std::uniform_int_distribution<std::ptrdiff_t>(0, std::ssize(values) - 1)(random_));
  }
  static std::string point(Vec2 p) { return fmt::format("[{:.4f} mm, {:.4f} mm]", p.x, p.y); }
  Vec2 anywhere() { return {between(8, width_ - 8), between(8, depth_ - 8)}; }

  std::string feature(int i) {
    const std::string head = fmt::format("name: f{}, material: {}", i, one_of({"a", "b"}));
    switch (one_of({0, 1, 2, 3, 4})) {
      case 0: return fmt::format("  - dot: {{{}, at: {}}}\n", head, point(anywhere()));
      case 1: return fmt::format("  - line: {{{}, from: {}, to: {}}}\n", head, point(anywhere()), point(anywhere()));
      case 2:
        return fmt::format("  - array: {{{}, at: {}, rows: 2, columns: 3, pitch: [4 mm, 4 mm]}}\n", head,
                           point({between(8, width_ - 17), between(8, depth_ - 13)}));
      case 3:
        return fmt::format("  - rectangle: {{{}, at: {}, size: [{:.3f} mm, {:.3f} mm], corner_tolerance: {} mm}}\n",
                           head, point({between(8, width_ / 2), between(8, depth_ / 2)}), between(3, width_ / 2 - 8),
                           between(3, depth_ / 2 - 8), one_of({0.0, 0.1, 0.3}));
      default: {
        std::string points = point(anywhere());
        for (int n = one_of({2, 3, 4, 5, 6}); n > 0; --n) points += ", " + point(anywhere());
        return fmt::format("  - polyline: {{{}, points: [{}], corner_tolerance: {} mm, closed: {}}}\n", head, points,
                           one_of({0.0, 0.05, 0.2, 1.0}), one_of({"true", "false"}));
      }
    }
  }

  std::mt19937_64 random_;
  double width_ = 0, depth_ = 0;
};

TEST(RandomJobs, deposits_lie_where_the_recipe_wants_them_or_the_recipe_is_refused_with_a_reason) {
  constexpr int kJobs = 15;
  int done = 0;
  for (std::uint64_t seed = 1; seed <= kJobs; ++seed) {
    SCOPED_TRACE(seed);
    Author author(seed);
    const std::string text = author.recipe();
    SCOPED_TRACE(text);
    const auto recipe = recipes::parse(text, fmt::format("random-{}.yaml", seed));
    ASSERT_TRUE(recipe) << to_text(recipe.error().front());
    test::Rig rig({.placement = author.placement(), .script = {}, .seed = seed});
    const record::JobResult result = rig.run(*recipe);
    EXPECT_TRUE(result.collisions.empty());
    if (result.exit_code == ExitCode::NotFeasible) {
      EXPECT_TRUE(result.deposits.empty()) << "refused after it had begun";
      continue;
    }
    ++done;
    test::expect_done(result);
    test::expect_deposits(*recipe, result);
  }
  EXPECT_GE(done, kJobs * 2 / 3);
}

}  // namespace
}  // namespace gantry
