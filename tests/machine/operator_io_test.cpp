// What the machine's own inputs do: emergency stop, door, stop, mode switch and buttons, by the virtual I/O station
// alone.
#include <algorithm>

#include "tests/machine/idle.hpp"
#include "tests/machine/order.hpp"
#include "tests/machine/said.hpp"

namespace gantry {
namespace {

using cycle::State;
using run::OrderKind;
using test::Idle;
using test::order;
using test::Rig;
using test::valve_open;

using test::kDemo;
using test::kShort;

bool clamped(const cycle::Snapshot& s) { return (s.outputs & config::bit(config::Output::Clamp)) != 0; }
std::string first_error(const record::JobResult& r) { return r.errors.empty() ? "" : to_text(r.errors.front()); }

/// What a reset comes to, whether it is refused at once or takes some cycles.
Result<void> reset(run::Owner& owner) {
  if (auto taken = owner.order(order(OrderKind::Reset)); !taken) return taken;
  return test::answer_of_reset(owner);
}

TEST(OperatorIo, an_emergency_stop_in_a_bead_is_named_and_the_same_owner_comes_back_by_reset_enable_home) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 2, after: 300 ms, do: emergency_stop}\n"
                     "- {at: cycle 90000, do: emergency_release}"});
  bool open_later = false;
  CycleIndex stopped_at = 0;
  rig.on_step = [&](run::Owner& owner) {
    const auto& s = owner.latest();
    if (stopped_at == 0 && (s.inputs & config::bit(config::Input::SafetyOk)) == 0 && s.block != 0) stopped_at = s.cycle;
    if (stopped_at != 0 && s.cycle > stopped_at + 2) open_later = open_later || valve_open(s);
  };
  const auto result = rig.run(kDemo);
  rig.on_step = {};
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::SafetyChainOpen) << first_error(result);
  EXPECT_EQ(result.exit_code, ExitCode::Refused);
  EXPECT_FALSE(result.interrupted.empty()) << "the cut deposit is named";
  EXPECT_FALSE(open_later);
  run::Owner& owner = rig.owner();
  EXPECT_EQ(owner.latest().latched, Fault::SafetyChainOpen);
  const auto early = reset(owner);
  ASSERT_FALSE(early) << "the emergency stop is still pressed";
  EXPECT_NE(early.error().message.find("G712"), std::string::npos) << early.error().message;
  ASSERT_LT(owner.latest().cycle, 90'000);
  while (owner.latest().cycle < 90'000 + 4000) ASSERT_TRUE(owner.idle());
  EXPECT_EQ(owner.latest().referenced, 0u) << "the drives have lost their supply";
  EXPECT_EQ(owner.latest().enabled, 0u);
  const auto cleared = reset(owner);
  ASSERT_TRUE(cleared) << to_text(cleared.error());
  EXPECT_EQ(owner.latest().state, State::Disabled);
  const auto enabled = owner.enable();
  ASSERT_TRUE(enabled) << to_text(enabled.error());
  const auto homed = owner.home();
  ASSERT_TRUE(homed) << to_text(homed.error());
  EXPECT_EQ(owner.latest().state, State::Ready);
}

TEST(OperatorIo, an_emergency_stop_of_an_idle_machine_voids_references_and_is_named) {
  Idle idle("[{at: cycle 20000, do: emergency_stop}, {at: cycle 22000, do: emergency_release}]");
  idle.pass_to(21'000);
  EXPECT_EQ(idle.now().latched, Fault::SafetyChainOpen);
  EXPECT_EQ(idle.now().referenced, 0u);
  idle.pass_to(26'000);
  EXPECT_TRUE(idle.whole());
  EXPECT_TRUE(reset(idle.owner()));
  EXPECT_TRUE(idle.owner().home());
}

TEST(OperatorIo, an_open_door_is_a_path_stop) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature bead 2, after: 300 ms, do: set_input, input: door_closed, on: false}"});
  const auto result = rig.run(kDemo);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::DoorOpen);
  EXPECT_EQ(rig.owner().latest().state, State::Stopped);
  EXPECT_EQ(rig.owner().latest().enabled, test::kAllAxes) << "the drives keep their torque";
}

TEST(OperatorIo, a_broken_wire_of_whatever_stops_is_a_stop) {
  const std::pair<const char*, Fault> cases[] = {{"stop", Fault::StopPressed},
                                                 {"door_closed", Fault::DoorOpen},
                                                 {"air_ok", Fault::AirMissing},
                                                 {"safety_ok", Fault::SafetyChainOpen}};
  for (const auto& [input, fault] : cases) {
    SCOPED_TRACE(input);
    Idle idle(std::string("[{at: cycle 20000, do: break_wire, input: ") + input + "}]");
    idle.pass_to(20'100);
    EXPECT_EQ(idle.now().latched, fault);
    EXPECT_EQ(idle.now().state, State::Stopped);
    EXPECT_FALSE(reset(idle.owner()));
    idle.pass_to(idle.now().cycle + 3000);
    EXPECT_FALSE(idle.owner().home());
    EXPECT_EQ(idle.now().latched, fault);
  }
}

TEST(OperatorIo, a_job_that_setup_refuses_has_dispensed_nothing_of_what_the_one_before_left_in_the_machine) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: cycle 90000, do: set_input, input: mode, on: false}"});
  const auto first = rig.run(kShort);
  ASSERT_TRUE(first.errors.empty()) << first_error(first);
  ASSERT_EQ(first.board, record::Board::Whole);
  ASSERT_LT(rig.owner().latest().cycle, 90'000);
  while (!rig.owner().in_setup()) ASSERT_TRUE(rig.owner().idle());
  const auto refused = rig.run(kShort);
  ASSERT_FALSE(refused.errors.empty());
  EXPECT_EQ(refused.errors.front().fault, Fault::SetupMode) << first_error(refused);
  EXPECT_EQ(refused.board, record::Board::Untouched);
  EXPECT_TRUE(refused.deposits.empty());
}

TEST(OperatorIo, in_setup_only_a_jog_moves_slowly_and_with_the_door_open) {
  Idle idle(
      "[{at: cycle 20000, do: set_input, input: mode, on: false},"
      " {at: cycle 20100, do: set_input, input: door_closed, on: false}]");
  idle.pass_to(20'200);
  EXPECT_EQ(idle.now().latched, Fault::None) << "in setup the door may be open";
  EXPECT_TRUE(idle.owner().in_setup());
  const auto homed = idle.owner().home();
  ASSERT_FALSE(homed);
  EXPECT_EQ(homed.error().fault, Fault::SetupMode);
  const auto job = idle.rig.run(kShort);
  ASSERT_FALSE(job.errors.empty());
  EXPECT_EQ(job.errors.front().fault, Fault::SetupMode) << first_error(job);
  double fastest = 0;
  bool opened = false;
  AxisVec before = idle.now().target;
  idle.owner().on_step([&] {
    const auto& s = idle.now();
    fastest = std::max(fastest, std::abs(s.target[0] - before[0]) * 1000);
    before = s.target;
    opened = opened || valve_open(s);
  });
  const auto jogged = idle.owner().jog({.by = {{"X", "15 mm"}}, .speed = "200 mm/s"});
  idle.owner().on_step({});
  ASSERT_TRUE(jogged) << to_text(jogged.error());
  EXPECT_GT(fastest, 15);
  EXPECT_LT(fastest, 20.1) << "reduced speed, whatever was asked for";
  EXPECT_FALSE(opened);
}

// ---- the mode is turned while a jog goes ----

/// X goes 200 mm where nothing meets it, from cycle 20000 on; what is in `script` comes at 20500.
struct TurnedJog {
  explicit TurnedJog(const std::string& script) : idle(script) { idle.pass_to(test::kTrouble); }
  Result<run::Jogged> jog(const char* speed) {
    before = idle.now().target;
    from = before[0];
    idle.owner().on_step([this] {
      const auto& s = idle.now();
      const double x_mm_s = std::abs(s.target[0] - before[0]) * 1000;
      if (idle.owner().in_setup()) fastest_in_setup = std::max(fastest_in_setup, x_mm_s);
      if (s.state == State::Stopped) fastest_stopped = std::max(fastest_stopped, x_mm_s);
      before = s.target;
      opened = opened || valve_open(s);
      if (on_cycle) on_cycle();
    });
    auto done = idle.owner().jog({.by = {{"X", "200 mm"}}, .speed = speed});
    idle.owner().on_step({});
    return done;
  }
  Idle idle;
  std::function<void()> on_cycle;
  AxisVec before{};
  double from = 0, fastest_in_setup = 0, fastest_stopped = 0;
  bool opened = false;
};

constexpr const char* kToSetup = "{at: cycle 20500, do: set_input, input: mode, on: false}";
constexpr const char* kToAutomatic = "{at: cycle 20500, do: set_input, input: mode, on: true}";
constexpr const char* kDoorOpens = "{at: cycle 20500, do: set_input, input: door_closed, on: false}";
constexpr const char* kInSetup = "{at: cycle 19950, do: set_input, input: mode, on: false}";

std::string script(std::initializer_list<const char*> entries) {
  std::string text;
  for (const char* entry : entries) text += (text.empty() ? "[" : ", ") + std::string(entry);
  return text + "]";
}

TEST(OperatorIo, a_jog_of_automatic_stops_when_the_mode_is_turned_to_setup_whatever_the_door_says) {
  for (const bool door_opens : {false, true}) {
    TurnedJog turned(door_opens ? script({kToSetup, kDoorOpens}) : script({kToSetup}));
    const auto jogged = turned.jog("100 mm/s");
    ASSERT_FALSE(jogged) << door_opens;
    EXPECT_EQ(jogged.error().fault, Fault::ModeChanged) << to_text(jogged.error());
    const auto& s = turned.idle.now();
    EXPECT_EQ(s.state, State::Stopped);
    EXPECT_EQ(s.enabled, test::kAllAxes) << "a stop on the path, with torque";
    const double went_mm = s.target[0] - turned.from;
    EXPECT_GT(went_mm, 30);  // half a second at 100 mm/s, less what it takes to start
    EXPECT_LT(went_mm, 60);
    EXPECT_EQ(turned.fastest_stopped, 0);
    EXPECT_TRUE(reset(turned.idle.owner())) << "the door may be open in setup";
    const auto slow = turned.idle.owner().jog({.by = {{"X", "2 mm"}}, .speed = ""});
    EXPECT_TRUE(slow) << to_text(slow.error());
  }
}

TEST(OperatorIo, a_jog_of_automatic_that_is_held_is_not_resumed_in_setup) {
  TurnedJog turned(script({kToSetup}));
  bool held = false, asked = false;
  turned.on_cycle = [&] {
    const auto& s = turned.idle.now();
    if (!held && s.cycle >= 20'300) held = turned.idle.owner().order(order(OrderKind::Hold)).has_value();
    if (s.cycle < 21'000 || asked) return;
    asked = true;
    EXPECT_FALSE(turned.idle.owner().order(order(OrderKind::Resume)));
  };
  const auto jogged = turned.jog("100 mm/s");
  ASSERT_TRUE(held);
  ASSERT_FALSE(jogged);
  EXPECT_EQ(jogged.error().fault, Fault::ModeChanged) << to_text(jogged.error());
  EXPECT_LT(turned.idle.now().target[0] - turned.from, 40);
  EXPECT_EQ(turned.fastest_in_setup, 0);
}

TEST(OperatorIo, the_start_button_resumes_nothing_in_setup) {
  TurnedJog turned(script({kInSetup, "{at: cycle 21000, do: press, input: start}"}));
  bool held = false, resumed = false;
  double pressed_at = 0, later = 0;
  turned.on_cycle = [&] {
    const auto& s = turned.idle.now();
    if (!held && s.cycle >= 20'300) held = turned.idle.owner().order(order(OrderKind::Hold)).has_value();
    if (s.cycle <= 20'990) pressed_at = s.target[0];
    if (s.cycle <= 21'990) later = s.target[0];
    if (s.cycle >= 22'000 && !resumed) resumed = turned.idle.owner().order(order(OrderKind::Resume)).has_value();
  };
  const auto jogged = turned.jog("100 mm/s");
  EXPECT_TRUE(jogged) << to_text(jogged.error());
  EXPECT_TRUE(held);
  EXPECT_TRUE(resumed) << "whoever jogs may resume it";
  EXPECT_EQ(later, pressed_at);
}

TEST(OperatorIo, a_jog_of_setup_goes_on_slowly_in_automatic_and_stops_where_the_door_is_open) {
  TurnedJog shut(script({kInSetup, kToAutomatic}));
  const auto jogged = shut.jog("100 mm/s");
  ASSERT_TRUE(jogged) << to_text(jogged.error());
  EXPECT_GT(jogged->duration_s, 200 / 20.0) << "at its reduced speed to the end";
  TurnedJog open(script({kInSetup, "{at: cycle 19950, do: set_input, input: door_closed, on: false}", kToAutomatic}));
  const auto stopped = open.jog("100 mm/s");
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().fault, Fault::DoorOpen) << to_text(stopped.error());
  EXPECT_LT(open.idle.now().target[0] - open.from, 20);
}

TEST(OperatorIo, an_override_above_100_makes_no_jog_faster) {
  Rig rig({.placement = "dx=0 mm", .change = [](config::Machine& m) { m.override_max = 1.5; }});
  ASSERT_TRUE(rig.owner().bring_up());
  ASSERT_TRUE(rig.owner().home());
  ASSERT_TRUE(rig.owner().order({.kind = OrderKind::Override, .value = 1.5}));
  ASSERT_TRUE(rig.owner().world()->add_script(script({"{do: set_input, input: mode, on: false}"})));
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(rig.owner().idle());
  ASSERT_TRUE(rig.owner().in_setup());
  double fastest = 0, x = rig.owner().latest().target[0];
  bool turned = false;
  const auto watch = [&] {
    const double now = rig.owner().latest().target[0];
    fastest = std::max(fastest, std::abs(now - x) * 1000);
    x = now;
    if (turned || fastest < 15) return;
    turned = true;  // and not in automatic either, from where it may be turned back
    ASSERT_TRUE(rig.owner().world()->add_script(script({"{do: set_input, input: mode, on: true}"})));
  };
  rig.owner().on_step(watch);
  const auto jogged = rig.owner().jog({.by = {{"X", "30 mm"}}, .speed = ""});
  ASSERT_TRUE(jogged) << to_text(jogged.error());
  EXPECT_TRUE(turned);
  EXPECT_LT(fastest, 20.1);
  ASSERT_FALSE(rig.owner().in_setup());
  const auto again = rig.owner().jog({.by = {{"X", "-25 mm"}}, .speed = ""});
  ASSERT_TRUE(again) << to_text(again.error());
  EXPECT_LT(fastest, 20.1) << "nor in automatic: it would not stand in time";
  rig.owner().on_step({});
}

TEST(OperatorIo, home_in_setup_is_refused_before_it_gives_torque) {
  Idle idle(script({kInSetup}));
  ASSERT_TRUE(idle.owner().disable());
  std::uint32_t enabled = 0;
  idle.owner().on_step([&] { enabled |= idle.now().enabled; });
  idle.pass_to(idle.now().cycle + 100);
  ASSERT_TRUE(idle.owner().in_setup());
  enabled = 0;
  for (const auto& axes : {std::vector<std::string>{}, {"C", "U"}}) {
    const auto homed = idle.owner().home(axes);
    ASSERT_FALSE(homed);
    EXPECT_EQ(homed.error().fault, Fault::SetupMode) << to_text(homed.error());
  }
  idle.pass_to(idle.now().cycle + 500);
  idle.owner().on_step({});
  EXPECT_EQ(enabled, 0u);
  EXPECT_EQ(idle.now().state, State::Disabled);
}

TEST(OperatorIo, a_job_that_runs_when_the_mode_is_turned_to_setup_stops) {
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 3, do: set_input, input: mode, on: false}"});
  const auto result = rig.run(kDemo);
  ASSERT_FALSE(result.errors.empty());
  EXPECT_EQ(result.errors.front().fault, Fault::ModeChanged) << first_error(result);
}

TEST(OperatorIo, the_clamp_opens_when_a_job_is_done_and_stays_shut_after_any_other_end) {
  Rig rig({.placement = "dx=0.5 mm"});
  const auto done = rig.run(kShort);
  ASSERT_EQ(done.exit_code, ExitCode::Done);
  EXPECT_FALSE(done.disturbed);
  ASSERT_TRUE(rig.owner().idle());
  EXPECT_FALSE(clamped(rig.owner().latest()));
  bool sent = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!sent && valve_open(owner.latest())) sent = owner.order(order(OrderKind::Abort)).has_value();
  };
  const auto aborted = rig.run(kShort);
  EXPECT_NE(aborted.exit_code, ExitCode::Done);
  EXPECT_TRUE(aborted.disturbed);
  rig.on_step = {};
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
  EXPECT_TRUE(clamped(rig.owner().latest()));
  ASSERT_TRUE(rig.owner().disable());
  ASSERT_TRUE(rig.owner().idle());
  EXPECT_TRUE(clamped(rig.owner().latest())) << "torque off lets no part go";
  ASSERT_TRUE(rig.owner().part_removed());
  ASSERT_TRUE(rig.owner().idle());
  EXPECT_FALSE(clamped(rig.owner().latest()));
}

TEST(OperatorIo, a_job_that_is_done_with_defects_does_not_open_the_clamp) {
  Rig rig({.placement = "dx=0.5 mm"});
  bool slowed = false;
  rig.on_step = [&](run::Owner& owner) {
    if (!slowed && valve_open(owner.latest()))
      slowed = owner.order({.kind = OrderKind::Override, .value = 0.2}).has_value();
  };
  const auto result = rig.run(kShort);
  rig.on_step = {};
  ASSERT_EQ(result.exit_code, ExitCode::DoneWithDefects) << first_error(result);
  EXPECT_TRUE(result.disturbed);
  for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
  EXPECT_TRUE(clamped(rig.owner().latest()));
  ASSERT_TRUE(rig.owner().part_removed());
  ASSERT_TRUE(rig.owner().idle());
  EXPECT_FALSE(clamped(rig.owner().latest()));
}

/// The order of the last moment: the axes stand at the park position, and the result is not told yet.
TEST(OperatorIo, an_abort_at_the_moment_of_done_ends_the_job_with_the_clamp_shut_or_comes_behind_its_end) {
  for (const int later : {0, 1, 2, 3}) {
    Rig rig({.placement = "dx=0.5 mm"});
    bool parks = false, sent = false;
    int since = -1;
    rig.on_step = [&](run::Owner& owner) {
      if (owner.undertaking() != run::Undertaking::Job) return;
      parks = parks || (owner.progress().doing == "parking" && owner.latest().block != 0);
      if (!parks || owner.latest().block != 0 || ++since != later) return;
      sent = owner.order(order(OrderKind::Abort)).has_value();
    };
    const auto result = rig.run(kShort);
    rig.on_step = {};
    EXPECT_TRUE(sent || later > 0) << "the job may be over before";
    for (int i = 0; i < 500; ++i) ASSERT_TRUE(rig.owner().idle());
    EXPECT_EQ(clamped(rig.owner().latest()), result.exit_code != ExitCode::Done)
        << later << ": " << first_error(result);
    EXPECT_EQ(result.board, record::Board::Whole);
    if (later == 0) {
      ASSERT_FALSE(result.errors.empty());
      EXPECT_EQ(result.errors.front().fault, Fault::Aborted);
      EXPECT_EQ(result.exit_code, info(Fault::Aborted).exit_code);
    }
  }
}

/// Serves the start button as the desk does.
TEST(OperatorIo, three_boards_in_a_row_with_the_buttons_alone) {
  Rig rig({.script = "- {at: cycle 3000, do: press, input: start}\n"
                     "- {at: cycle 60000, do: press, input: start}\n"
                     "- {at: cycle 120000, do: press, input: start}"});
  ASSERT_TRUE(rig.owner().bring_up());
  std::vector<std::string> placements;
  while (rig.owner().latest().cycle < 180'000) {
    ASSERT_TRUE(rig.owner().idle());
    if (!rig.owner().take_start()) continue;
    const auto result = rig.run(kShort);
    EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
    EXPECT_EQ(result.deposits.size(), result.features_total) << "a new board, with nothing on it";
    placements.push_back(result.placement);
  }
  ASSERT_EQ(placements.size(), 3u);
  EXPECT_NE(placements[0], placements[1]);
  EXPECT_NE(placements[1], placements[2]);
}

TEST(OperatorIo, a_start_button_that_hangs_starts_nothing_after_a_stop) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: cycle 3000, do: press, input: start, hold: 60 s}\n"
                     "- {at: cycle 30000, do: press, input: stop}\n"
                     "- {at: cycle 31000, do: press, input: reset}\n"
                     "- {at: cycle 80000, do: press, input: start}"});
  ASSERT_TRUE(rig.owner().bring_up());
  int starts = 0;
  CycleIndex last = 0;
  while (rig.owner().latest().cycle < 90'000) {
    ASSERT_TRUE(rig.owner().idle());
    if (!rig.owner().take_start()) continue;
    ++starts;
    last = rig.owner().latest().cycle;
  }
  EXPECT_EQ(starts, 2);
  EXPECT_GE(last, 79'000) << "only after it was seen released";
}

TEST(OperatorIo, hold_and_start_are_hold_and_resume_of_a_job) {
  Rig rig({.placement = "dx=0.5 mm",
           .script = "- {at: feature dot 3, after: 200 ms, do: press, input: hold}\n"
                     "- {at: feature dot 3, after: 3 s, do: press, input: start}"});
  CycleIndex held = 0;
  rig.on_step = [&](run::Owner& owner) { held += owner.held() ? 1 : 0; };
  const auto result = rig.run(kDemo);
  EXPECT_EQ(result.exit_code, ExitCode::Done) << first_error(result);
  EXPECT_GT(held, 2000);
  EXPECT_TRUE(result.disturbed);
}

TEST(OperatorIo, start_beside_a_job_that_runs_is_a_resume_that_has_nothing_to_do) {
  const test::Said said;
  Rig rig({.placement = "dx=0.5 mm", .script = "- {at: feature dot 3, after: 200 ms, do: press, input: start}"});
  EXPECT_EQ(rig.run(kDemo).exit_code, ExitCode::Done);
  EXPECT_EQ(said.count({"button start: 'resume' is refused", "is not on hold; nothing has to be done"}), 1)
      << said.all();
}

TEST(OperatorIo, an_axis_that_stands_on_its_limit_switch_is_enabled_and_led_off_by_home) {
  Idle idle("[{at: cycle 20000, do: drive_fault, axis: X, code: 0x800}]");  // iD286: a limit, told as a warning
  idle.pass_to(20'200);
  EXPECT_EQ(idle.now().latched, Fault::None) << "it stands";
  ASSERT_TRUE(idle.owner().disable());
  const auto enabled = idle.owner().enable();
  EXPECT_TRUE(enabled) << to_text(enabled.error());
  const auto homed = idle.owner().home();
  EXPECT_TRUE(homed) << to_text(homed.error());
}

}  // namespace
}  // namespace gantry
