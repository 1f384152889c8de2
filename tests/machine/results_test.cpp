// A job that says "done" is done: random boards, and in half of the jobs something happens to them (holds, overrides,
// faults, aborts), or the machine is not what its file says (the needle's tip, the board's tilt, its placement). The
// oracle (board_oracle.hpp) has the world's deposits.csv and the author's own drawing.
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <random>
#include <unistd.h>

#include "app/record/defects.hpp"
#include "app/record/summary.hpp"
#include "recipes/recipe.hpp"
#include "tests/machine/board_oracle.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using test::Verdict;
using test::Wanted;

struct Material {
  const char* name;
  double speed_mm_s, gap_mm, dot_ms;
  bool follows;
  int open_lead_ms = 8, close_lead_ms = 6;  ///< as late as the valve is
};

/// A recipe, and what its author wants.
class Author {
 public:
  explicit Author(std::uint64_t seed) : random_(seed), mistakes_(seed) {}

  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  template <class T>
  T one_of(std::initializer_list<T> values) {
    return *(values.begin() + std::uniform_int_distribution<std::ptrdiff_t>(0, std::ssize(values) - 1)(random_));
  }

  std::string recipe() {
    const int marks = one_of({0, 3, 3, 4}), touches = one_of({0, 3, 3, 4});
    fixture = marks == 0 && one_of({true, true, false});
    reference = marks > 0 || fixture;
    std::string text = "version: 1\nrecipe: random\n";
    if (fixture) text += "placement: fixture\n";
    text += "board: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\n";
    const std::array<Vec2, 4> corners{Vec2{4, 5}, {86, 55}, {85, 4}, {4, 55}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(marks); ++i)
      text += fmt::format("{}  m{}: {{at: {}, diameter: 1.5 mm}}\n", i == 0 ? "marks:\n" : "", i, point(corners[i]));
    const std::array<Vec2, 4> probed{Vec2{20, 15}, {70, 20}, {45, 48}, {15, 50}};
    for (std::size_t i = 0; i < static_cast<std::size_t>(touches); ++i)
      text += fmt::format("{}  t{}: {{at: {}}}\n", i == 0 ? "touches:\n" : "", i, point(probed[i]));
    text += "materials:\n";
    for (const char* name : {"a", "b"}) {
      materials_.push_back({name, one_of({10.0, 20.0, 50.0, 100.0}), touches < 3 ? 0.8 : one_of({0.2, 0.4}),
                            one_of({33.0, 60.0}), one_of({true, false, false, false})});
      Material& m = materials_.back();
      mistake(m);
      text += fmt::format(
          "  {}: {{speed: {} mm/s, gap: {} mm, valve_open_lead: {} ms, valve_close_lead: {} ms, dot_time: {} ms, "
          "settle_time: 10 ms, retract: 3 mm, flow_follows_speed: {}}}\n",
          m.name, m.speed_mm_s, m.gap_mm, m.open_lead_ms, m.close_lead_ms, m.dot_ms, m.follows);
    }
    text += "features:\n";
    const int count = one_of({2, 3, 4, 5});
    for (int i = 0; i < count; ++i) text += feature(i);
    return text;
  }

  std::vector<Wanted> wanted;
  bool fixture = false, reference = false;

 private:
  static std::string point(Vec2 p) { return fmt::format("[{:.4f} mm, {:.4f} mm]", p.x, p.y); }
  Vec2 anywhere() { return {between(10, 80), between(10, 50)}; }
  Vec2 as_written(Vec2 p) { return {std::round(p.x * 1e4) / 1e4, std::round(p.y * 1e4) / 1e4}; }

  std::string feature(int i) {
    const Material& m = materials_[static_cast<std::size_t>(one_of({0, 1}))];
    const std::string head = fmt::format("name: f{}, material: {}", i, m.name);
    Wanted w{.bead = true,
             .points = {},
             .corner_mm = 0,
             .speed_mm_s = m.speed_mm_s,
             .gap_mm = m.gap_mm,
             .dot_s = m.dot_ms * 1e-3,
             .flow_follows_speed = m.follows,
             .shot_s = (m.dot_ms + m.open_lead_ms - 8 - (m.close_lead_ms - 6)) * 1e-3};
    const auto add = [&] {
      w.points.push_back(as_written(anywhere()));
      return point(w.points.back());
    };
    std::string text;
    switch (one_of({0, 1, 2, 2, 3})) {
      case 0:
        w.bead = false;
        text = fmt::format("  - dot: {{{}, at: {}}}\n", head, add());
        break;
      case 1: {
        const std::string from = add();
        text = fmt::format("  - line: {{{}, from: {}, to: {}}}\n", head, from, add());
        break;
      }
      case 2: {
        w.corner_mm = one_of({0.0, 0.1, 0.2});
        const bool closed = one_of({true, false});
        std::string points = add();
        for (int n = one_of({1, 2, 3}); n >= 0; --n) points += ", " + add();
        text = fmt::format("  - polyline: {{{}, points: [{}], corner_tolerance: {} mm, closed: {}}}\n", head, points,
                           w.corner_mm, closed);
        if (closed) w.points.push_back(w.points.front());
        break;
      }
      default: {
        const Vec2 at = as_written({between(10, 40), between(10, 30)}),
                   size = as_written({between(8, 35), between(8, 20)});
        w.corner_mm = one_of({0.0, 0.1, 0.3});
        w.points = {at, at + Vec2{size.x, 0}, at + size, at + Vec2{0, size.y}, at};
        text = fmt::format("  - rectangle: {{{}, at: {}, size: {}, corner_tolerance: {} mm}}\n", head, point(at),
                           point(size), w.corner_mm);
      }
    }
    wanted.push_back(std::move(w));
    return text;
  }

  /// One material in six has leads that do not fit the valve.
  void mistake(Material& m) {
    const auto draw = mistakes_() % 24;
    if (draw == 0) m.open_lead_ms = 2;
    if (draw == 1) m.open_lead_ms = 14;
    if (draw == 2) m.close_lead_ms = 0;
    if (draw == 3) m.close_lead_ms = 12;
  }

  std::mt19937_64 random_, mistakes_;
  std::vector<Material> materials_;
};

/// What happens to the second job on the rig.
struct Trouble {
  enum class Kind { Hold, Override, Both, Abort, Fault } kind = Kind::Hold;
  CycleIndex at = 0, lasts = 0;  ///< cycles from the job's start
  double factor = 1;
};

/// Orders that come at their cycle.
void meddle(run::Owner& owner, const Trouble& t, CycleIndex job_began) {
  const CycleIndex now = owner.latest().cycle - job_began;
  const auto order = [&](run::OrderKind kind, double value = 1) {
    static_cast<void>(owner.order({.kind = kind, .value = value}));  // what does not fit is refused
  };
  using Kind = Trouble::Kind;
  if (now == t.at) {
    if (t.kind == Kind::Override || t.kind == Kind::Both) order(run::OrderKind::Override, t.factor);
    if (t.kind == Kind::Hold || t.kind == Kind::Both) order(run::OrderKind::Hold);
    if (t.kind == Kind::Abort) order(run::OrderKind::Abort);
  }
  if (now >= t.at + t.lasts) {
    if (now == t.at + t.lasts) order(run::OrderKind::Override, 1);
    if (owner.held()) order(run::OrderKind::Resume);
  }
}

class Jobs {
 public:
  int judged = 0, good = 0, spoilt = 0, near = 0, failed = 0;

  void judge(const Author& author, const record::JobResult& result, run::Owner& owner,
             const std::vector<test::RawShot>& undisturbed) {
    const std::string file = std::filesystem::temp_directory_path() / fmt::format("gantry-results-{}.csv", getpid());
    ASSERT_TRUE(owner.world()->write_deposits(file));
    shots = test::read_shots(file);
    std::filesystem::remove(file);
    std::vector<test::Wanted> wanted = author.wanted;
    for (const record::Joined& j : result.joined)
      wanted.at(std::stoul(j.feature.substr(1))).joins_mm.push_back(j.at_mm);
    const test::Opinion o = test::opinion(wanted, shots, undisturbed);
    ++judged;
    const std::string word = record::result_word(result);
    std::string told;
    for (const record::Defect& d : result.defects)
      told += fmt::format("\n  {} {}: {}", d.feature, record::name(d.kind), d.message);
    SCOPED_TRACE(fmt::format("{}, board {}; the oracle: {} {} {}", word, record::name(result.board), o.board,
                             static_cast<int>(o.verdict), o.why) +
                 told);
    if (o.verdict == Verdict::Near) {
      ++near;
      EXPECT_NE(result.board, record::Board::Untouched);
      return;
    }
    const bool is_good = o.verdict == Verdict::Good && author.reference;
    if (word == "done" || word == "done_with_defects") {
      EXPECT_EQ(word, is_good ? "done" : "done_with_defects");
      EXPECT_EQ(result.exit_code, is_good ? ExitCode::Done : ExitCode::DoneWithDefects);
      ++(is_good ? good : spoilt);
    } else {
      ++failed;
      EXPECT_FALSE(result.errors.empty());
    }
    const bool unknown = o.board == "whole" && !author.reference;
    EXPECT_EQ(record::name(result.board), unknown ? "defects" : o.board);
    EXPECT_EQ(result.defects.empty(), is_good || o.board == "untouched");
  }

  std::vector<test::RawShot> shots;
};

TEST(Results, the_word_and_the_board_agree_with_an_oracle_over_the_worlds_deposits) {
  const char* rounds = std::getenv("GANTRY_ROUNDS");
  const char* first = std::getenv("GANTRY_SEED");
  const auto from = static_cast<std::uint64_t>(first != nullptr ? std::atoll(first) : 1);
  Jobs jobs;
  for (std::uint64_t seed = from, end = from + static_cast<std::uint64_t>(rounds != nullptr ? std::atoi(rounds) : 6);
       seed < end; ++seed) {
    Author author(seed);
    const std::string text = author.recipe();
    SCOPED_TRACE(fmt::format("seed {}\n{}", seed, text));
    const auto recipe = recipes::parse(text, "random.yaml");
    ASSERT_TRUE(recipe) << to_text(recipe.error().front());
    // What the machine does not know of itself, and where the board lies.
    const double tip = author.one_of({0.0, 0.0, 0.0, 0.05, 0.2}), up = author.one_of({0.0, 0.0, 0.05, 0.2}),
                 tilt_deg = author.one_of({0.0, 0.02, 0.1, 0.3}), turn = author.between(0, 6.283);
    const bool off = author.reference ? !author.fixture : author.one_of({true, false});
    const std::string placement =
        fmt::format("dx={:.3f} mm, dy={:.3f} mm, rot={:.3f} deg, dz={:.3f} mm, tilt_x={} deg, tilt_y=0 deg",
                    off ? author.between(-1.5, 1.5) : 0, off ? author.between(-1.5, 1.5) : 0,
                    off ? author.between(-1, 1) : 0, author.between(-0.15, 0.15), tilt_deg);
    SCOPED_TRACE(fmt::format("tip {} mm, {} mm up, board at {}", tip, up, placement));
    Trouble trouble{.kind = static_cast<Trouble::Kind>(author.one_of({0, 0, 1, 1, 1, 2, 3, 4}))};
    test::Rig rig({.placement = placement, .seed = seed, .change = [&](config::Machine& m) {
                     m.override_max = 2;
                     m.sim.needle_error = {tip * std::cos(turn), tip * std::sin(turn), up};
                   }});
    const record::JobResult quiet = rig.run(*recipe);
    if (quiet.exit_code == ExitCode::NotFeasible && quiet.deposits.empty()) continue;  // a path that is not free
    jobs.judge(author, quiet, rig.owner(), {});
    const std::vector<test::RawShot> undisturbed = jobs.shots;
    if (undisturbed.empty() || undisturbed.size() != author.wanted.size()) continue;
    // Somewhere between shortly before the first shot and the end of the last.
    const CycleIndex dispensed = undisturbed.back().closed - undisturbed.front().opened;
    CycleIndex first_shot = 0;
    trouble.lasts = static_cast<CycleIndex>(author.between(60, 1500));
    trouble.factor = author.one_of({0.3, 0.5, 0.8, 1.3, 1.8});
    const auto delay = static_cast<CycleIndex>(author.between(-50, static_cast<double>(dispensed)));
    const auto axis = author.one_of({0, 1, 2});
    bool struck = false;
    rig.on_step = [&](run::Owner& owner) {
      const auto& s = owner.latest();
      if (first_shot == 0 && s.feature != motion::kTravel) first_shot = s.cycle;
      if (first_shot == 0) return;
      trouble.at = std::max<CycleIndex>(1, delay);
      if (trouble.kind != Trouble::Kind::Fault) return meddle(owner, trouble, first_shot);
      if (struck || s.cycle - first_shot < trouble.at) return;
      struck = true;
      static_cast<void>(owner.world()->add_script(fmt::format(
          "- {{do: drive_fault, axis: {}, code: 0x0E}}", std::array{"X", "Z", "X"}[static_cast<std::size_t>(axis)])));
    };
    const record::JobResult second = rig.run(*recipe);
    rig.on_step = {};
    SCOPED_TRACE(fmt::format("trouble {} at {} for {}, factor {}", static_cast<int>(trouble.kind), trouble.at,
                             trouble.lasts, trouble.factor));
    jobs.judge(author, second, rig.owner(), undisturbed);
    if (testing::Test::HasFailure() && rounds == nullptr) break;
  }
  std::printf("%d jobs: %d good, %d spoilt, %d failed, %d too close to a limit to say\n", jobs.judged, jobs.good,
              jobs.spoilt, jobs.failed, jobs.near);
  EXPECT_GT(jobs.good, 0);
  EXPECT_GT(jobs.spoilt, 0);
  EXPECT_LE(jobs.near, jobs.judged / 10 + 1);
}

// A drive that fails while a dot's valve is open shuts it: by the plan, or at once, and 6 ms later it is shut. How long
// it was open is known, though the job has ended before.
TEST(Results, a_job_that_ends_while_a_dot_is_dispensed_says_how_long_its_valve_was_open) {
  const auto recipe = recipes::parse(
      "version: 1\nrecipe: dots\nplacement: fixture\n"
      "board: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\nmaterials:\n"
      "  glue: {speed: 12 mm/s, gap: 0.8 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 50 ms, "
      "settle_time: 20 ms, retract: 2 mm}\nfeatures:\n"
      "  - dot: {name: d1, material: glue, at: [30 mm, 30 mm]}\n"
      "  - dot: {name: d2, material: glue, at: [20 mm, 40 mm]}\n",
      "dots.yaml");
  ASSERT_TRUE(recipe) << to_text(recipe.error().front());
  for (const int after_ms : {20, 40, 44, 48}) {
    SCOPED_TRACE(after_ms);
    test::Rig rig(
        {.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg",
         .script = fmt::format("- {{at: feature d2, after: {} ms, do: drive_fault, axis: X, code: 0x0E}}", after_ms)});
    const record::JobResult result = rig.run(*recipe);
    EXPECT_EQ(record::result_word(result), "failed");
    ASSERT_EQ(result.deposits.size(), 2u);
    const auto& d2 = result.deposits[1];
    EXPECT_EQ(d2.id, "d2");
    EXPECT_GT(d2.closed_cycle, d2.opened_cycle);
    // It is told to shut at 44 ms; earlier, where the fault is known, a cycle or some after it came.
    const double least_s = std::min(50, after_ms + 6) * 1e-3, most_s = std::min(50, after_ms + 6 + 6) * 1e-3;
    EXPECT_GE(d2.open_s, least_s - 1e-3);
    EXPECT_LE(d2.open_s, most_s + 1e-3);
    const auto of_d2 = std::count_if(result.defects.begin(), result.defects.end(),
                                     [](const record::Defect& d) { return d.feature == "d2"; });
    EXPECT_EQ(of_d2, after_ms < 40 ? 1 : 0) << record::to_json(result.defects).dump(1);
    for (const record::Defect& d : result.defects) {
      if (d.feature != "d2") continue;
      EXPECT_TRUE(d.message.starts_with(fmt::format("a shot of {:.3g} ms instead of 50 ms", d2.open_s * 1e3)))
          << d.message;
    }
  }
}

// Beads that nobody disturbs, and that the machine cannot dispense at the speed that their author wants: a curve too
// tight, corners too near to each other. The oracle knows of no plan.
TEST(Results, a_bead_that_is_never_at_its_speed_is_a_defect_and_is_told_before_anything_moves) {
  const std::string text =
      "version: 1\nrecipe: slow\nplacement: fixture\n"
      "board: {size: [90 mm, 60 mm], thickness: 8 mm, frame: pallet}\nmaterials:\n"
      "  fast: {speed: 100 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 300 ms, "
      "settle_time: 10 ms, retract: 3 mm}\n"
      "  dosed: {speed: 100 mm/s, gap: 0.3 mm, valve_open_lead: 8 ms, valve_close_lead: 6 ms, dot_time: 300 ms, "
      "settle_time: 10 ms, retract: 3 mm, flow_follows_speed: true}\nfeatures:\n"
      "  - circle: {name: ring, material: fast, centre: [30 mm, 40 mm], radius: 3 mm}\n"
      "  - polyline: {name: zig, material: fast, points: [[40 mm, 40 mm], [43 mm, 43 mm], [46 mm, 40 mm], [49 mm, 43 "
      "mm]], corner_tolerance: 0.05 mm}\n"
      "  - line: {name: far, material: fast, from: [15 mm, 15 mm], to: [60 mm, 15 mm]}\n"
      "  - rectangle: {name: frame, material: fast, at: [15 mm, 20 mm], size: [50 mm, 12 mm], corner_tolerance: 0.3 "
      "mm}\n"
      "  - circle: {name: dosed_ring, material: dosed, centre: [60 mm, 43 mm], radius: 3 mm}\n";
  const auto recipe = recipes::parse(text, "slow.yaml");
  ASSERT_TRUE(recipe) << to_text(recipe.error().front());
  test::Rig rig({.placement = "dx=0 mm, dy=0 mm, rot=0 deg, dz=0 mm, tilt_x=0 deg, tilt_y=0 deg", .seed = 1});
  const record::JobResult result = rig.run(*recipe);
  EXPECT_EQ(record::result_word(result), "done_with_defects");
  EXPECT_EQ(result.board, record::Board::Defects);
  ASSERT_EQ(result.defects.size(), 2u) << record::to_json(result.defects).dump(1);
  for (const record::Defect& d : result.defects) EXPECT_EQ(d.kind, record::Defect::Kind::Speed);
  EXPECT_EQ(result.defects[0].feature, "ring");
  EXPECT_NE(result.defects[0].message.find("instead of 100 mm/s"), std::string::npos) << result.defects[0].message;
  EXPECT_NE(result.defects[0].message.find("radius 3 mm"), std::string::npos) << result.defects[0].message;
  EXPECT_EQ(result.defects[1].feature, "zig");
  EXPECT_NE(result.defects[1].message.find("corners lie too near"), std::string::npos) << result.defects[1].message;

  const std::string file = std::filesystem::temp_directory_path() / fmt::format("gantry-slow-{}.csv", getpid());
  ASSERT_TRUE(rig.owner().world()->write_deposits(file));
  const auto shots = test::read_shots(file);
  std::filesystem::remove(file);
  ASSERT_EQ(shots.size(), 5u);
  const Verdict wanted[] = {Verdict::Spoilt, Verdict::Spoilt, Verdict::Good, Verdict::Good, Verdict::Good};
  const auto circle = [](Vec2 centre) {
    std::vector<Vec2> points;
    for (int i = 0; i <= 720; ++i)
      points.push_back(centre + Vec2{3 * std::cos(i * M_PI / 360), 3 * std::sin(i * M_PI / 360)});
    return points;
  };
  const std::vector<std::vector<Vec2>> drawn{circle({30, 40}),
                                             {{40, 40}, {43, 43}, {46, 40}, {49, 43}},
                                             {{15, 15}, {60, 15}},
                                             {{15, 20}, {65, 20}, {65, 32}, {15, 32}, {15, 20}},
                                             circle({60, 43})};
  for (std::size_t i = 0; i < shots.size(); ++i) {
    const Wanted w{.bead = true,
                   .points = drawn[i],
                   .corner_mm = 0.3,
                   .speed_mm_s = 100,
                   .gap_mm = 0.3,
                   .dot_s = 0.3,
                   .flow_follows_speed = i == 4};
    const test::Opinion o = test::opinion({w}, {shots[i]}, {});
    EXPECT_EQ(o.verdict, wanted[i]) << i << ": " << o.why;
  }
}

}  // namespace
}  // namespace gantry
