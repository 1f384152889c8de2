// The direction walk, with the simulated machine's side altered alone: the operator of these tests says what he sees,
// and what he sees is where the virtual motors really are.
#include "app/run/walk.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>

#include "app/job/walk.hpp"
#include "app/stations/accepted.hpp"
#include "config/look_alikes.hpp"
#include "core/units.hpp"
#include "tests/altered.hpp"
#include "tests/machine/rig.hpp"
#include "tests/machine/said.hpp"

namespace gantry::test {
namespace {

constexpr const char* kSetup = "[{do: set_input, input: mode, on: false}]";

void no_alias(config::Machine& m) {
  for (config::Station& s : m.stations) s.alias = 0;
}
/// The devices stand in each other's place on the line.
void swap_cables(config::Machine& m, std::string_view a, std::string_view b) {
  std::swap(station(m, a).position, station(m, b).position);
}
/// And whoever commissioned them has written what belongs into their places, so that no parameter shows it.
void swap_cables_and_commission(config::Machine& m, std::string_view a, std::string_view b) {
  swap_cables(m, a, b);
  std::swap(station(m, a).profile.startup, station(m, b).profile.startup);
}

struct Operator {
  explicit Operator(const std::function<void(config::Machine&)>& change = {},
                    const std::function<void(config::Machine&)>& wired = {}, const char* script = kSetup)
      : rig({.placement = "dx=0 mm", .script = script, .change = change, .wired = wired}) {
    const auto up = rig.owner().bring_up();
    EXPECT_TRUE(up) << to_text(up.error());
    for (int i = 0; i < 20; ++i) EXPECT_TRUE(rig.owner().idle());
    start = look();
  }
  AxisVec look() { return rig.owner().world()->axes().value(); }
  void watch() {
    const AxisVec now = look();
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double by = now[i] - start[i];
      if (std::abs(by) > std::abs(farthest[i])) farthest[i] = by;
      if (std::abs(by) > std::abs(most[i])) most[i] = by;
      fastest = std::max(fastest, std::abs(now[i] - last[i]) / seconds(rig.machine().bus.cycle));
      last[i] = now[i];
    }
    outputs |= rig.owner().latest().outputs;
    most_axes = std::max(most_axes, moving());
  }
  [[nodiscard]] int moving() const {
    return static_cast<int>(std::ranges::count_if(farthest, [](double by) { return std::abs(by) > 0.02; }));
  }
  std::string seen() {
    for (const config::Axis& axis : rig.machine().axes) {
      const double by = std::exchange(farthest[axis.id.value], 0);
      if (std::abs(by) < 0.5 * std::abs(job::walk_by(rig.machine(), axis))) continue;
      return axis.name + (by > 0 ? "+" : "-");
    }
    return "nothing";
  }
  Result<std::vector<const config::Axis*>> walk() {
    bool moved = false;
    last = look();
    return run::walk(rig.owner(), rig.machine(),
                     {.say = [&](const std::string& words) { said += words; },
                      .hear = [&]() -> Result<std::optional<std::string>> {
                        moved = !moved;
                        return moved ? "" : seen();
                      },
                      .poll = [&] { watch(); }});
  }

  /// Of the real motors, whoever was ordered.
  void expect_no_farther_than_a_walk() {
    for (const config::Axis& axis : rig.machine().axes)
      EXPECT_LE(std::abs(most[axis.id.value]), job::walk_most(axis) * 1.01) << axis.name;
  }

  Rig rig;
  AxisVec start{}, last{}, farthest{}, most{};
  double fastest = 0;
  int most_axes = 0;
  std::uint32_t outputs = 0;
  std::string said;
};

TEST(Walk, of_the_machine_as_shipped_each_axis_goes_out_and_back_alone_slowly_and_not_homed) {
  Operator op;
  const auto walked = op.walk();
  ASSERT_TRUE(walked) << to_text(walked.error());
  ASSERT_EQ(walked->size(), 5u);
  EXPECT_EQ(walked->front()->name, "Z") << "what goes up goes first";
  EXPECT_EQ((*walked)[1]->name, "U");
  EXPECT_GT(op.most[op.rig.machine().z.value], 0.4);
  EXPECT_LT(op.most[op.rig.machine().u->value], -0.3) << "the lift counts downwards: what hangs on it goes up";
  op.expect_no_farther_than_a_walk();
  const AxisVec end = op.look();
  for (const config::Axis* axis : *walked)
    EXPECT_NEAR(end[axis->id.value], op.start[axis->id.value], 3 / axis->counts_per_unit) << axis->name;
  EXPECT_LT(op.fastest, 3.0);
  EXPECT_EQ(op.most_axes, 1);
  EXPECT_EQ(op.outputs & config::bit(config::Output::Valve), 0u);
  EXPECT_EQ(op.rig.owner().latest().referenced, 0u);
  EXPECT_NE(op.said.find("Z ('z' (position 4)) goes by +0.5 mm at 1 mm/s"), std::string::npos) << op.said;
}

TEST(Walk, swapped_cables_of_stations_that_nothing_tells_apart_are_seen_and_named_with_the_remedy) {
  Operator op(no_alias, [](auto& m) { swap_cables_and_commission(m, "x", "z"); });
  const auto walked = op.walk();
  ASSERT_FALSE(walked);
  EXPECT_EQ(walked.error().fault, Fault::AxisNotAsWired);
  for (const char* words : {"axis Z", "X moved", "'x' (position 1)", "'z' (position 4)", "exchange their bus cables"})
    EXPECT_NE(to_text(walked.error()).find(words), std::string::npos) << to_text(walked.error());
  op.expect_no_farther_than_a_walk();
}

TEST(Walk, a_turned_polarity_is_seen_and_named_with_what_turns_it) {
  for (const char* name : {"X", "Y", "Z", "C", "U"}) {
    Operator op({}, [&](auto& m) {
      for (auto& ref : std::ranges::find(m.axes, name, &config::Axis::name)->drives) ref.invert = !ref.invert;
    });
    const auto walked = op.walk();
    ASSERT_FALSE(walked) << name;
    EXPECT_EQ(walked.error().where, std::string("axis ") + name);
    EXPECT_NE(walked.error().message.find("the other way"), std::string::npos) << to_text(walked.error());
    EXPECT_NE(walked.error().message.find("parameters.direction"), std::string::npos) << to_text(walked.error());
  }
}

TEST(Walk, swapped_motors_of_one_station_are_named_as_that) {
  Operator op({}, [](auto& m) {
    auto c = std::ranges::find(m.axes, "C", &config::Axis::name),
         u = std::ranges::find(m.axes, "U", &config::Axis::name);
    std::swap(c->drives, u->drives);
  });
  const auto walked = op.walk();
  ASSERT_FALSE(walked);
  EXPECT_NE(walked.error().message.find("cables of the two motors"), std::string::npos) << to_text(walked.error());
  op.expect_no_farther_than_a_walk();
}

TEST(Walk, is_refused_outside_of_setup_and_on_a_limit_switch_and_by_what_refuses_torque) {
  Operator automatic({}, {}, "[]");
  const auto in_automatic = automatic.rig.owner().walk("X");
  ASSERT_FALSE(in_automatic);
  EXPECT_EQ(in_automatic.error().fault, Fault::Refused);
  EXPECT_EQ(automatic.rig.owner().latest().enabled, 0u);

  Operator limit({}, [](auto& m) { m.sim.axes[1].start = m.sim.axes[1].neg_limit - 1; });
  const auto on_limit = limit.rig.owner().walk("X");
  ASSERT_FALSE(on_limit);
  EXPECT_EQ(on_limit.error().fault, Fault::LimitSwitch) << to_text(on_limit.error());
  EXPECT_NE(to_text(on_limit.error()).find("axis Y"), std::string::npos) << to_text(on_limit.error());
  EXPECT_NE(on_limit.error().message.find("by hand"), std::string::npos);
  EXPECT_EQ(limit.look(), limit.start);

  Operator current({}, [](auto& m) { holds(m, "y1", {0x2000, 0}, 8000); });
  const auto doubted = current.rig.owner().walk("X");
  ASSERT_FALSE(doubted);
  EXPECT_EQ(doubted.error().fault, Fault::ParameterDiffers);
}

TEST(Walk, a_limit_switch_that_is_met_ends_it_and_an_abort_ends_it_at_once) {
  Operator limit({}, [](auto& m) { m.sim.axes[0].start = m.sim.axes[0].pos_limit - 0.4; });
  const auto met = limit.rig.owner().walk("X");
  ASSERT_FALSE(met);
  EXPECT_EQ(met.error().fault, Fault::LimitSwitch) << to_text(met.error());

  Operator op;
  int steps = 0;
  op.rig.owner().on_step([&] {
    if (op.rig.owner().latest().state == cycle::State::Running && ++steps == 200)
      op.rig.owner().interrupt({Fault::Interrupted, "enough", ""});
  });
  const auto ended = op.rig.owner().walk("X");
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().fault, Fault::Interrupted);
  EXPECT_LT(std::abs(op.look()[0] - op.start[0]), 0.6);
  EXPECT_FALSE(op.rig.owner().walk("X")) << "who was interrupted undertakes nothing";
}

TEST(Walk, answers_are_read_as_people_write_them_and_judged) {
  Operator op;
  const config::Machine& m = op.rig.machine();
  EXPECT_EQ(run::read_seen(m, " x + ")->axis, "X");
  EXPECT_FALSE(run::read_seen(m, "Z-")->up);
  EXPECT_EQ(run::read_seen(m, "nothing")->axis, "");
  for (const char* bad : {"", "X", "+", "W+", "yes", "X+-"}) EXPECT_FALSE(run::read_seen(m, bad)) << bad;
  EXPECT_FALSE(run::judge_seen(m, m.axes[0], {}));
  EXPECT_TRUE(run::judge_seen(m, m.axes[0], {"X", true}));
  const config::Axis& lift = m.axes[m.u->value];
  EXPECT_TRUE(run::judge_seen(m, lift, {"U", false}));
  EXPECT_FALSE(run::judge_seen(m, lift, {"U", true}));
  EXPECT_NE(run::judge_seen(m, lift, {"X", true}).error().message.find("motor cables"), std::string::npos)
      << "stations of two kinds are not exchanged on the bus";
}

TEST(Walk, moves_nothing_but_for_enter_alone_and_does_not_ask_for_ever) {
  const auto with = [](Operator& op, std::vector<std::string> answers) {
    std::size_t next = 0;
    return run::walk(op.rig.owner(), op.rig.machine(),
                     {.say = [](const std::string&) {},
                      .hear = [&]() -> Result<std::optional<std::string>> {
                        return next < answers.size() ? std::optional(answers[next++]) : std::nullopt;
                      },
                      .poll = [&] { op.watch(); }});
  };
  for (const char* words : {"no", "q", "abort", "Z+"}) {
    Operator op;
    const auto ended = with(op, {words});
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().fault, Fault::Aborted);
    EXPECT_EQ(op.look(), op.start) << words;
  }
  Operator op;
  const auto rubbish = with(op, {"", "y", "y", "y", "y"});
  ASSERT_FALSE(rubbish);
  EXPECT_EQ(rubbish.error().fault, Fault::BadValue);
}

TEST(Walk, ends_where_the_machine_was_stopped_while_it_waited) {
  Operator op;
  int asked = 0;
  const auto ended =
      run::walk(op.rig.owner(), op.rig.machine(),
                {.say = [](const std::string&) {},
                 .hear = [&]() -> Result<std::optional<std::string>> {
                   if (++asked == 1) return "";
                   if (asked == 2) {
                     EXPECT_TRUE(op.rig.owner().world()->add_script("[{do: set_input, input: stop, on: false}]"));
                   }
                   if (asked > 3000) return fail(Fault::Aborted, "it waits on");
                   return std::nullopt;
                 }});
  ASSERT_FALSE(ended);
  EXPECT_NE(ended.error().message.find("walk anew"), std::string::npos) << to_text(ended.error());
}

/// A state folder of its own, and what was accepted there.
struct Kept {
  Kept() { std::filesystem::create_directories(folder); }
  ~Kept() { std::filesystem::remove_all(folder); }
  std::string folder = testing::TempDir() + "/walk-" + std::to_string(::getpid());
};

TEST(Walk, what_was_seen_is_kept_with_a_date_and_notices_a_swap_by_the_serial_numbers) {
  Kept kept;
  const auto machine = [] {
    auto m = *config::load_machine("config/machines/dispenser.yaml");
    no_alias(m);
    return m;
  }();
  const auto options = [&](const std::function<void(config::Machine&)>& wired) {
    auto truth = std::make_shared<config::Machine>(machine);
    wired(*truth);
    run::OwnerOptions o;
    o.virtual_time = true;
    o.state = kept.folder;
    o.sim.wired = truth;
    return o;
  };
  ASSERT_EQ(config::look_alikes(machine).size(), 2u);
  {
    auto owner = run::Owner::open(machine, options([](auto&) {}));
    ASSERT_TRUE(owner);
    ASSERT_TRUE((*owner)->bring_up());
    ASSERT_TRUE((*owner)->keep_walk("2026-11-24"));
  }
  config::Machine after = machine;
  ASSERT_TRUE(stations::read_accepted(stations::accepted_file(kept.folder, "sim"), after));
  EXPECT_EQ(station(after, "x").accepted->walked, "2026-11-24");
  EXPECT_EQ(station(after, "x").accepted->walked_as, "position 1; X: slot 0; direction 0");
  EXPECT_FALSE(station(after, "io").accepted) << "it moves nothing";
  EXPECT_FALSE(station(after, "x").accepted->compared) << "a walk shows which axis moves, not what a type plate says";
  {
    const auto doubts = config::look_alikes(after);
    ASSERT_EQ(doubts.size(), 1u) << "no walk tells the sides of Y";
    EXPECT_NE(doubts[0].find("'y1', 'y2'"), std::string::npos) << doubts[0];
  }
  for (config::Station& s : after.stations)
    if (s.accepted) s.accepted->compared = true;
  EXPECT_TRUE(config::look_alikes(after).empty());
  ASSERT_TRUE(stations::write_accepted(stations::accepted_file(kept.folder, "sim"), after));
  {
    auto owner = run::Owner::open(machine, options([](auto&) {}));
    ASSERT_TRUE(owner);
    ASSERT_TRUE((*owner)->bring_up());
    ASSERT_TRUE((*owner)->keep_walk("2026-11-25"));
    config::Machine again = machine;
    ASSERT_TRUE(stations::read_accepted(stations::accepted_file(kept.folder, "sim"), again));
    EXPECT_EQ(station(again, "y1").accepted->walked, "2026-11-25");
    EXPECT_TRUE(station(again, "y1").accepted->compared) << "the same device still";
  }
  {
    auto owner = run::Owner::open(machine, options([](auto& m) { swap_cables(m, "x", "z"); }));
    ASSERT_TRUE(owner);
    const auto up = (*owner)->bring_up();
    ASSERT_FALSE(up);
    EXPECT_NE(up.error().message.find("swapped"), std::string::npos) << to_text(up.error());
  }
  // The file turns an axis round: what was seen is of another machine.
  auto turned = machine;
  turned.axes[0].drives[0].invert = true;
  Said said;
  auto owner = run::Owner::open(turned, options([](auto&) {}));
  ASSERT_TRUE(owner);
  ASSERT_TRUE((*owner)->bring_up());
  EXPECT_EQ(said.count({"station 'x' was walked 2026-11-25", "inverted"}), 1) << said.all();
}

TEST(Walk, a_wrong_answer_voids_what_earlier_walks_have_said) {
  Kept kept;
  const auto options = [&](const std::function<void(config::Machine&)>& wired) {
    auto truth = std::make_shared<config::Machine>(*config::load_machine("config/machines/dispenser.yaml"));
    no_alias(*truth), wired(*truth);
    run::OwnerOptions o;
    o.virtual_time = true;
    o.state = kept.folder;
    o.sim.wired = truth;
    return o;
  };
  auto machine = *config::load_machine("config/machines/dispenser.yaml");
  no_alias(machine);
  const auto kept_of = [&](const char* name) {
    config::Machine after = machine;
    EXPECT_TRUE(stations::read_accepted(stations::accepted_file(kept.folder, "sim"), after));
    return *station(after, name).accepted;
  };
  auto owner = run::Owner::open(machine, options([](auto& m) { m.axes[0].drives[0].invert ^= true; }));
  ASSERT_TRUE(owner);
  ASSERT_TRUE((*owner)->bring_up());
  ASSERT_TRUE((*owner)->world()->add_script(kSetup));
  for (int i = 0; i < 20; ++i) ASSERT_TRUE((*owner)->idle());
  ASSERT_TRUE((*owner)->keep_walk("2026-11-24"));
  ASSERT_EQ(kept_of("x").walked, "2026-11-24");
  ASSERT_NE(kept_of("x").serial, 0u);
  int heard = 0;
  const char* const answers[] = {"", "Z+", "", "U-", "", "what?", "X-"};
  const auto walked = run::walk(**owner, machine,
                                {.say = [](const std::string&) {},
                                 .hear = [&]() -> Result<std::optional<std::string>> { return answers[heard++]; }});
  ASSERT_FALSE(walked);
  EXPECT_EQ(walked.error().fault, Fault::AxisNotAsWired);
  EXPECT_EQ(walked.error().where, "axis X");
  EXPECT_NE(walked.error().message.find("is void"), std::string::npos) << to_text(walked.error());
  EXPECT_EQ(heard, 7) << "what cannot be read is asked for once more";
  for (const char* name : {"x", "z", "y1"}) {
    EXPECT_EQ(kept_of(name).walked, "") << name;
    EXPECT_EQ(kept_of(name).serial, 0u) << name;
  }
  EXPECT_EQ(config::look_alikes(machine).size(), 2u);

  // What was seen is told, also where it cannot be written.
  ASSERT_TRUE((*owner)->keep_walk("2026-11-24"));
  std::filesystem::create_directories(stations::accepted_file(kept.folder, "sim") + ".part/in the way");
  heard = 4;
  const char* const again[] = {"", "", "", "", "", "X-"};
  const auto unwritten = run::walk(**owner, machine,
                                   {.say = [](const std::string&) {},
                                    .hear = [&]() -> Result<std::optional<std::string>> { return again[heard++]; }});
  ASSERT_FALSE(unwritten);
  EXPECT_EQ(unwritten.error().fault, Fault::AxisNotAsWired);
  EXPECT_NE(unwritten.error().message.find("could not be voided"), std::string::npos) << to_text(unwritten.error());
}

/// What is said of these two, which show these serial numbers.
std::string alike(const config::Machine& m, const std::string& a, std::uint32_t serial_a, const std::string& b,
                  std::uint32_t serial_b) {
  const auto found = config::not_told_apart(m, [&](const config::Station& s) -> std::optional<std::uint32_t> {
    if (s.name == a) return serial_a;
    if (s.name == b) return serial_b;
    return std::nullopt;
  });
  return found.empty() ? "" : found.front().text;
}

// Of two drives that look alike and show no serial number, a swap after the walk cannot be known: it is said.
TEST(Walk, what_tells_look_alikes_apart_is_alias_serials_or_the_walk_in_that_order) {
  config::Machine m = *config::load_machine("config/machines/dispenser.yaml");
  no_alias(m);
  config::Station &x = station(m, "x"), &z = station(m, "z");
  EXPECT_NE(alike(m, "x", 0, "z", 0), "");
  const auto walked = [&](config::Station& s, std::uint32_t serial) {
    s.accepted =
        config::Accepted{.serial = serial, .date = "d", .walked = "2026-11-24", .walked_as = config::wiring_of(m, s)};
  };
  walked(x, 0), walked(z, 0);
  EXPECT_EQ(alike(m, "x", 0, "z", 0), "");
  bool told = false;
  for (const std::string& s : config::look_alikes(m)) told = told || s.find("only the walk of 2026-11-24") != s.npos;
  EXPECT_TRUE(told);
  x.accepted = config::Accepted{.serial = 7, .date = "d"}, z.accepted = config::Accepted{.serial = 8, .date = "d"};
  EXPECT_NE(alike(m, "x", 7, "z", 8), "") << "nobody has looked which of them stands where";
  walked(x, 7), walked(z, 8);
  EXPECT_EQ(alike(m, "x", 7, "z", 8), "");
  EXPECT_EQ(alike(m, "x", 9, "z", 8), "") << "the one that is known leaves its place to the spare part";
  EXPECT_NE(alike(m, "x", 9, "z", 10), "") << "of two new ones nothing is known";
  x.accepted->walked_as = z.accepted->walked_as = "other";
  EXPECT_NE(alike(m, "x", 7, "z", 8), "");
  walked(x, 7), walked(z, 8);
  std::swap(x.position, z.position);
  EXPECT_NE(alike(m, "x", 7, "z", 8), "") << "the file has them in other places since";
  std::swap(x.position, z.position);
  walked(x, 0), walked(z, 0);
  m.axes[0].drives[0].invert = true;
  EXPECT_NE(alike(m, "x", 0, "z", 0), "") << "the machine file says otherwise since";
  x.alias = 1, z.alias = 4;
  EXPECT_EQ(alike(m, "x", 0, "z", 0), "");

  config::Station &y1 = station(m, "y1"), &y2 = station(m, "y2");
  walked(y1, 0), walked(y2, 0);
  EXPECT_NE(alike(m, "y1", 0, "y2", 0), "") << "both move Y";
  walked(y1, 5), walked(y2, 6);
  EXPECT_NE(alike(m, "y1", 5, "y2", 6), "") << "nobody has compared them with their type plates";
  y1.accepted->compared = true;
  EXPECT_NE(alike(m, "y1", 5, "y2", 6), "") << "one of two";
  y2.accepted->compared = true;
  EXPECT_EQ(alike(m, "y1", 5, "y2", 6), "");
}

}  // namespace
}  // namespace gantry::test
