// Where marks are found, against drawn truth (drawn_image.hpp).
#include "vision/find.hpp"

#include <chrono>
#include <cstdio>
#include <gtest/gtest.h>

#include "tests/vision/drawn_image.hpp"

namespace gantry::vision {
namespace {

using test::DrawnImage;

constexpr std::uint64_t kSeed = 20240611;
const MarkModel kModel{Disc{100}, true};

class Draw {
 public:
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec2 around(Vec2 c, double r) { return c + rotated({r * std::sqrt(real(0, 1)), 0}, real(0, 6.2831853)); }
  std::mt19937_64 engine{kSeed};
};

struct Scatter {
  int found = 0, missed = 0, gross = 0;
  double square = 0, normalised = 0;
  Vec2 bias;
  void add(const Result<FoundMark>& mark, Vec2 truth) {
    if (!mark) {
      ++missed;
      std::printf("  missed: %s\n", mark.error().message.c_str());
      return;
    }
    const Vec2 e = mark->at_px - truth;
    if (norm(e) > 2) {
      ++gross;
      return;
    }
    ++found;
    square += dot(e, e);
    bias = bias + e;
    normalised += e.x * e.x / (mark->sigma_px.x * mark->sigma_px.x) + e.y * e.y / (mark->sigma_px.y * mark->sigma_px.y);
  }
  [[nodiscard]] double rms() const { return std::sqrt(square / std::max(found, 1)); }
  [[nodiscard]] Vec2 mean() const { return bias * (1.0 / std::max(found, 1)); }
  void print(const char* name) const {
    std::printf("%-28s found %d missed %d gross %d rms %.4f px bias (%+.4f, %+.4f) nees %.2f\n", name, found, missed,
                gross, rms(), mean().x, mean().y, normalised / std::max(1, 2 * found));
  }
};

TEST(FindMark, has_no_bias_over_sub_pixel_phases) {
  std::mt19937_64 random(kSeed);
  for (const double blur : {0.0, 0.7, 1.5}) {
    Scatter scatter;
    double worst = 0;
    for (int j = 0; j < 5; ++j)
      for (int i = 0; i < 5; ++i) {
        const Vec2 truth{120 + 0.2 * i, 110 + 0.2 * j};
        DrawnImage drawn(240, 220, 60);
        drawn.disc(truth, 50, 180);
        drawn.blur(blur);
        const auto mark = find_mark(drawn.image(0, random), kModel, {118, 113}, 40);
        ASSERT_TRUE(mark) << mark.error().message;
        scatter.add(mark, truth);
        worst = std::max(worst, norm(mark->at_px - truth));
      }
    scatter.print("phases");
    EXPECT_LT(norm(scatter.mean()), 0.003) << "blur " << blur;
    EXPECT_LT(worst, 0.02) << "blur " << blur;
  }
}

/// Full frames of the reference camera: the mark anywhere within reach, size and blur within what optics do.
struct Scene {
  Vec2 truth;
  Image image;
};
struct SceneRules {
  double noise = 2, contrast = 110;
  bool bright = true, mark = true;
  int stains = 0, decoys = 0;
  bool glare = false;
};
Scene make_scene(Draw& draw, const SceneRules& r) {
  const double ground = r.bright ? 70 : 180, sign = r.bright ? 1 : -1;
  DrawnImage drawn(1280, 1024, ground);
  const Vec2 truth = draw.around({639.5, 511.5}, 380);
  std::vector<Vec2> taken{truth};
  for (int i = 0; i < r.decoys; ++i) {  // things of the mark's kind that are no mark
    const Vec2 at{draw.real(60, 1220), draw.real(60, 964)};
    // Apart: a disc that fills most of a ring is a stained mark to anybody's eyes.
    if (std::any_of(taken.begin(), taken.end(), [&](Vec2 other) { return norm(at - other) < 180; })) continue;
    taken.push_back(at);
    const double grey = ground + sign * draw.real(0.6, 1.2) * r.contrast, angle = draw.real(0, 3);
    switch (i % 6) {
      case 0: drawn.disc(at, 50 * draw.real(0.6, 0.85), grey); break;
      case 1: drawn.disc(at, 50 * draw.real(1.2, 1.6), grey); break;
      case 2: drawn.ring(at, 50, 50 * draw.real(0.35, 0.8), grey); break;
      case 3: drawn.box(at, {95, 95}, angle, grey); break;
      case 4: drawn.box(at, {160, 70}, angle, grey); break;
      default: drawn.disc(at, 50, ground - sign * 0.4 * r.contrast); break;
    }
  }
  const double radius = 50 * draw.real(0.985, 1.015);
  if (r.mark) drawn.disc(truth, radius, ground + sign * r.contrast);
  for (int i = 0; i < r.stains; ++i)  // about 15 % of the edge each
    drawn.disc(truth + rotated({radius, 0}, draw.real(0, 6.28)), draw.real(18, 24),
               ground + sign * draw.real(-0.3, 0.5) * r.contrast);
  if (r.glare) drawn.disc(truth + rotated({draw.real(25, 50), 0}, draw.real(0, 6.28)), draw.real(10, 18), 255);
  drawn.blur(draw.real(0.6, 1.4));
  drawn.light({draw.real(-2e-4, 2e-4), draw.real(-2e-4, 2e-4)});
  return {truth, drawn.image(r.noise, draw.engine)};
}

struct Row {
  const char* name;
  SceneRules rules;
  double rms_px;
  int missed = 0;  ///< no mark rather than a wrong one
};
class FindMarkIn : public testing::TestWithParam<Row> {};

TEST_P(FindMarkIn, full_frames_is_exact_and_never_wrong) {
  Draw draw;
  Scatter scatter;
  double slowest_ms = 0;
  for (int i = 0; i < 16; ++i) {
    const Scene scene = make_scene(draw, GetParam().rules);
    const auto start = std::chrono::steady_clock::now();
    const auto mark = find_mark(scene.image, {Disc{100}, GetParam().rules.bright}, {639.5, 511.5}, 470);
    slowest_ms = std::max(slowest_ms,
                          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    scatter.add(mark, scene.truth);
  }
  scatter.print(GetParam().name);
  std::printf("  slowest %.1f ms, seed %llu\n", slowest_ms, static_cast<unsigned long long>(kSeed));
  EXPECT_EQ(scatter.gross, 0);
  EXPECT_LE(scatter.missed, GetParam().missed);
  EXPECT_LT(scatter.rms(), GetParam().rms_px);
}

INSTANTIATE_TEST_SUITE_P(
    , FindMarkIn,
    testing::Values(Row{"clean", {.noise = 2}, 0.01}, Row{"dark", {.noise = 2, .bright = false}, 0.01},
                    Row{"noise_15", {.noise = 15}, 0.06}, Row{"contrast_30", {.noise = 5, .contrast = 30}, 0.08},
                    Row{"stain", {.noise = 3, .stains = 1}, 0.05},
                    Row{"glare", {.noise = 3, .contrast = 90, .glare = true}, 0.05},
                    Row{"decoys", {.noise = 3, .decoys = 14}, 0.02},
                    Row{"hard_mix", {.noise = 8, .contrast = 50, .stains = 1, .decoys = 14, .glare = true}, 0.1, 2}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(FindMark, finds_nothing_where_there_is_none) {
  Draw draw;
  int wrong = 0;
  for (int i = 0; i < 30; ++i) {
    SceneRules rules{.noise = i % 4 == 0 ? 0.0 : draw.real(1, 20), .mark = false, .decoys = i % 3 == 0 ? 0 : 16};
    rules.contrast = draw.real(30, 140);
    const Scene scene = make_scene(draw, rules);
    const auto mark = find_mark(scene.image, kModel, {639.5, 511.5}, 470);
    if (mark) {
      ++wrong;
      std::printf("  wrong at (%.1f, %.1f): truth would be (%.1f, %.1f) scale %.3f contrast %.1f coverage %.2f\n",
                  mark->at_px.x, mark->at_px.y, scene.truth.x, scene.truth.y, mark->scale, mark->contrast,
                  mark->coverage);
    } else {
      EXPECT_EQ(mark.error().fault, Fault::MarkNotFound) << mark.error().message;
    }
  }
  EXPECT_EQ(wrong, 0) << "seed " << kSeed;
}

TEST(FindMark, refuses_two_marks_and_names_both_places) {
  std::mt19937_64 random(kSeed);
  DrawnImage drawn(640, 480, 60);
  drawn.disc({200, 240}, 50, 180);
  drawn.disc({440, 240}, 50, 180);
  drawn.blur(1);
  const Image image = drawn.image(2, random);
  const auto both = find_mark(image, kModel, {320, 240}, 200);
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().fault, Fault::MarkAmbiguous);
  EXPECT_NE(both.error().message.find("(200.0, 240.0)"), std::string::npos) << both.error().message;
  EXPECT_NE(both.error().message.find("(440.0, 240.0)"), std::string::npos) << both.error().message;
  const auto left = find_mark(image, kModel, {210, 240}, 100);  // the other one is out of the window
  ASSERT_TRUE(left) << left.error().message;
  EXPECT_NEAR(left->at_px.x, 200, 0.02);
}

TEST(FindMark, speaks_of_millimetres_from_where_the_mark_should_be_when_it_knows_the_scale) {
  std::mt19937_64 random(kSeed);
  DrawnImage drawn(640, 480, 60);
  drawn.disc({200, 250}, 50, 180);
  drawn.disc({440, 200}, 50, 180);
  drawn.blur(1);
  const Image image = drawn.image(2, random);
  const auto both = find_mark(image, kModel, {320, 240}, 200, {.mm_per_px = 0.02});
  ASSERT_FALSE(both);
  EXPECT_NE(both.error().message.find("(-2.40, -0.20) mm from there"), std::string::npos) << both.error().message;
  EXPECT_NE(both.error().message.find("(+2.40, +0.80) mm from there"), std::string::npos) << both.error().message;
  const auto none = find_mark(image, kModel, {320, 240}, 50, {.mm_per_px = 0.02});
  ASSERT_FALSE(none);
  EXPECT_NE(none.error().message.find("no mark within 1.00 mm of where it should be"), std::string::npos)
      << none.error().message;
}

struct Refused {
  const char* name;
  const char* says;
  std::function<void(DrawnImage&)> draw;
};
class FindMarkRefuses : public testing::TestWithParam<Refused> {};
TEST_P(FindMarkRefuses, and_says_why) {
  std::mt19937_64 random(kSeed);
  DrawnImage drawn(480, 480, 60);
  GetParam().draw(drawn);
  drawn.blur(1);
  const auto mark = find_mark(drawn.image(2, random), kModel, {240, 240}, 120);
  ASSERT_FALSE(mark) << "found at " << mark->at_px.x << ", " << mark->at_px.y;
  EXPECT_EQ(mark.error().fault, Fault::MarkNotFound);
  EXPECT_NE(mark.error().message.find(GetParam().says), std::string::npos) << mark.error().message;
}
constexpr Vec2 kAt{230, 250};
INSTANTIATE_TEST_SUITE_P(, FindMarkRefuses,
                         testing::Values(Refused{"too_small", "size", [](DrawnImage& d) { d.disc(kAt, 45, 180); }},
                                         Refused{"too_large", "size", [](DrawnImage& d) { d.disc(kAt, 55, 180); }},
                                         Refused{"faint", "contrast", [](DrawnImage& d) { d.disc(kAt, 50, 67); }},
                                         Refused{"ring", "inside", [](DrawnImage& d) { d.ring(kAt, 50, 25, 180); }},
                                         Refused{"disc_within_disc", "is none",
                                                 [](DrawnImage& d) { d.disc(kAt, 62, 120), d.disc(kAt, 50, 180); }},
                                         Refused{"half", "is none",
                                                 [](DrawnImage& d) {
                                                   d.disc(kAt, 50, 180), d.box({kAt.x + 50, kAt.y}, {100, 120}, 0, 60);
                                                 }},
                                         Refused{"third_cut", "is none",
                                                 [](DrawnImage& d) {
                                                   d.disc(kAt, 50, 180), d.box({kAt.x + 75, kAt.y}, {100, 160}, 0, 60);
                                                 }}),
                         [](const auto& row) { return std::string(row.param.name); });

TEST(FindMark, cut_by_the_image_border_is_found_only_while_most_of_it_shows) {
  std::mt19937_64 random(kSeed);
  for (const double x : {45.0, 20.0, 0.0}) {
    DrawnImage drawn(400, 300, 60);
    drawn.disc({x, 150}, 50, 180);
    drawn.blur(1);
    const auto mark = find_mark(drawn.image(2, random), kModel, {50, 150}, 100);
    if (x > 40) {
      ASSERT_TRUE(mark) << mark.error().message;
      EXPECT_NEAR(mark->at_px.x, x, 0.05);
    } else if (mark) {
      EXPECT_NEAR(mark->at_px.x, x, 0.1);
    }
    if (x == 0.0) {
      EXPECT_FALSE(mark);
    }
  }
}

TEST(FindMark, works_for_small_and_large_marks) {
  std::mt19937_64 random(kSeed);
  for (const double diameter : {14.0, 30.0, 60.0, 200.0, 400.0}) {
    DrawnImage drawn(640, 512, 60);
    const Vec2 truth{310.3, 262.7};
    drawn.disc(truth, diameter / 2, 180);
    drawn.blur(0.8);
    const auto mark = find_mark(drawn.image(2, random), {Disc{diameter}, true}, {320, 256}, 50);
    ASSERT_TRUE(mark) << diameter << ": " << mark.error().message;
    EXPECT_LT(norm(mark->at_px - truth), 0.05) << diameter;
    EXPECT_NEAR(mark->scale, 1, 0.01) << diameter;
  }
}

TEST(FindMark, refuses_frames_that_are_no_images) {
  EXPECT_FALSE(find_mark(Image{}, kModel, {0, 0}, 10));
  EXPECT_FALSE(find_mark(Image{100, 100, std::vector<std::uint8_t>(99)}, kModel, {50, 50}, 10));
  EXPECT_FALSE(find_mark(Image{80, 80, std::vector<std::uint8_t>(6400)}, kModel, {40, 40}, 10));
  EXPECT_FALSE(find_mark(Image{200, 200, std::vector<std::uint8_t>(40000)}, {Disc{0}, true}, {40, 40}, 10));
  EXPECT_FALSE(find_mark(Image{200, 200, std::vector<std::uint8_t>(40000)}, kModel, {40, 40}, 100));
}

}  // namespace
}  // namespace gantry::vision
