// How far a stop takes is known before it is asked for: at random instants of whole jobs, on lines, blends and curves,
// at any override. The judge is the way that the loop then goes.
#include <algorithm>
#include <fmt/format.h>
#include <random>

#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using run::OrderKind;
using test::Rig;

constexpr int kStops = 15;  // of a job, which is aborted then

struct Found {
  int stops = 0, on_beads = 0;
  double most = 0, least = 1e9;  ///< of what was told, over stops of 0.1 mm and more
};

/// Holds now at random instants, and goes on; what was told before each is compared with the way that it takes.
/// `soon`: while the tool still gathers the speed that the hold before has cost.
Found hold_at_random(const std::string& recipe, std::uint64_t seed, bool soon = false) {
  Rig rig({.placement = "dx=0.5 mm"});
  std::mt19937_64 random(seed);
  const auto uniform = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  Found found;
  CycleIndex next = 0, resume_at = 0;
  std::optional<double> told;
  double from_mm = 0, along_block_mm = 0;
  std::uint32_t block = 0;
  bool bead = false;
  rig.on_step = [&](run::Owner& owner) {
    const cycle::Snapshot& s = owner.latest();
    if (told) {
      if (s.block == block) along_block_mm = s.along_block_mm;
      if (s.state != cycle::State::Held && s.block == block) return;
      const double went_mm = along_block_mm - from_mm;
      EXPECT_LE(went_mm, *told * 1.001 + 1e-6) << recipe << " seed " << seed << " cycle " << s.cycle;
      if (went_mm > 0.1) {
        found.most = std::max(found.most, went_mm / *told);
        found.least = std::min(found.least, went_mm / *told);
      }
      ++found.stops, found.on_beads += bead ? 1 : 0;
      told.reset();
      resume_at = s.cycle + 300;
    } else if (resume_at != 0) {
      if (s.cycle < resume_at) return;
      if (owner.held() && !owner.order({.kind = OrderKind::Resume})) return;
      resume_at = 0;
      if (found.stops == kStops) {
        EXPECT_TRUE(owner.order({.kind = OrderKind::Abort}));
      }
      next = s.cycle + static_cast<CycleIndex>(soon ? uniform(5, 300) : uniform(50, 5000));
      if (uniform(0, 1) < 0.4) {
        EXPECT_TRUE(owner.order({.kind = OrderKind::Override, .value = uniform(0.2, 1)}));
      }
    } else if (s.block != 0 && s.cycle >= next && s.path_speed > 1 && found.stops < kStops) {
      const auto mm = owner.stop_mm();
      ASSERT_TRUE(mm);
      if (!owner.order({.kind = OrderKind::Hold, .now = true})) return;
      told = mm, from_mm = along_block_mm = s.along_block_mm, block = s.block;
      bead = s.feature != motion::kTravel;
    }
  };
  const record::JobResult r = rig.run(recipe);
  for (const Error& e : r.errors) EXPECT_EQ(e.fault, Fault::Aborted) << to_text(e);
  return found;
}

TEST(StopAhead, what_is_told_is_never_less_than_the_way_that_a_stop_takes) {
  Found all;
  for (std::uint64_t seed = 1; seed <= 2; ++seed)
    for (const char* recipe : {"recipes/patterns.yaml", "recipes/demo-board.yaml"}) {
      const Found f = hold_at_random(recipe, seed);
      all.stops += f.stops, all.on_beads += f.on_beads;
      all.most = std::max(all.most, f.most), all.least = std::min(all.least, f.least);
    }
  EXPECT_GT(all.stops, 40);
  EXPECT_GT(all.on_beads, 8);
  EXPECT_GT(all.least, 0.2) << "nor much more";
  fmt::print("{} stops, {} on beads: {:.3f} to {:.3f} of what was told\n", all.stops, all.on_beads, all.least,
             all.most);
}

TEST(StopAhead, what_is_told_while_the_tool_gathers_speed_is_no_less_either) {
  int stops = 0;
  for (std::uint64_t seed = 3; seed <= 6; ++seed) {
    const Found f = hold_at_random(seed % 2 == 0 ? "recipes/patterns.yaml" : "recipes/demo-board.yaml", seed, true);
    stops += f.stops;
    EXPECT_GT(f.least, 0.1) << "nor much more";
    fmt::print("{} stops: {:.3f} to {:.3f} of what was told\n", f.stops, f.least, f.most);
  }
  EXPECT_GT(stops, 40);
}

TEST(StopAhead, nothing_is_told_where_the_tool_stands) {
  Rig rig({.placement = "dx=0.5 mm"});
  EXPECT_FALSE(rig.owner().stop_mm());
  bool moved = false;
  rig.on_step = [&](run::Owner& owner) {
    if (owner.latest().path_speed == 0) {
      EXPECT_FALSE(owner.stop_mm());
    }
    moved = moved || owner.stop_mm().has_value();
  };
  EXPECT_TRUE(rig.run("recipes/patterns.yaml").errors.empty());
  EXPECT_TRUE(moved);
  EXPECT_FALSE(rig.owner().stop_mm());
}

}  // namespace
}  // namespace gantry
