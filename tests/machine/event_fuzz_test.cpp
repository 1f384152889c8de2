// Random orders, buttons, faults, lost clients and signals at random cycles of homing, jogs and short jobs, in virtual
// time, judged cycle by cycle (event_judge.hpp). After each round of trouble the world is put in order, and reset,
// enable, home have to lead to Ready. One seed, told step by step, and the campaign:
//   GANTRY_FUZZ_SEED=7 GANTRY_FUZZ_EVENTS=1 build/release/bin/machine_event_fuzz_test
//   GANTRY_FUZZ_EVENTS=100000 build/release/bin/machine_event_fuzz_test
#include <array>
#include <cstdlib>
#include <fmt/format.h>
#include <map>
#include <random>
#include <spdlog/spdlog.h>

#include "core/log.hpp"
#include "tests/machine/event_judge.hpp"
#include "tests/machine/rig.hpp"

namespace gantry {
namespace {

using cycle::Snapshot;
using cycle::State;
using run::OrderKind;
using run::Undertaking;

constexpr CycleIndex kLongestHold = 3000, kResetAnswer = 5000;
constexpr CycleIndex kScriptIsOver = 5000;  // cycles after which everything that was scripted has happened
constexpr CycleIndex kBusComesBack = 30'000;
constexpr CycleIndex kAfterFault = 5000;  // in which what the world does to a drive shows
/// A side that loses its supply at full speed stands up to 47 mm from the other one, which brakes: the refusal says
/// that `reset` and `home` take out what the beam bears at a time, 12 mm.
constexpr int kMostTimes = 4;
constexpr CycleIndex kSpringsBack = 3000;  // of an axis that was held and is let go
constexpr std::uint32_t kAll = 0b11111;

std::uint64_t number_of(const char* variable, std::uint64_t otherwise) {
  const char* text = std::getenv(variable);
  return text != nullptr ? std::strtoull(text, nullptr, 10) : otherwise;
}

class Chance {
 public:
  explicit Chance(std::uint64_t seed) : random_(seed) {}
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  template <class T>
  T one_of(std::initializer_list<T> of) {
    return *(of.begin() + below(static_cast<int>(of.size())));
  }

 private:
  std::mt19937_64 random_;
};

/// What the machines have been through: a fuzzer that reaches nothing finds nothing.
struct Seen {
  std::array<long, cycle::kStates> cycles{};        ///< in each state
  std::map<std::string, std::pair<int, int>> ends;  ///< of what was undertaken: done, ended otherwise
  std::map<Fault, int> latched;

  [[nodiscard]] int ended(const std::string& what) const { return ends.count(what) != 0 ? ends.at(what).second : 0; }
  [[nodiscard]] int done(const std::string& what) const { return ends.count(what) != 0 ? ends.at(what).first : 0; }
  [[nodiscard]] std::string said() const {
    std::string text = "cycles:";
    for (std::size_t i = 0; i < cycles.size(); ++i)
      text += fmt::format(" {} {}", cycle::name(static_cast<State>(i)), cycles[i]);
    text += "\ndone/ended otherwise:";
    for (const auto& [what, n] : ends) text += fmt::format(" {} {}/{}", what, n.first, n.second);
    text += "\nlatched:";
    for (const auto& [fault, n] : latched) text += fmt::format(" {} {}", std::string_view(code(fault)), n);
    return text;
  }
};

/// The job of all episodes: compiled once.
struct Work {
  recipes::Recipe recipe;
  recipes::Job job;
};

/// One machine, one seed: rounds of trouble, and after each the way out by verbs.
class Episode {
 public:
  Episode(std::uint64_t seed, const Work& work, Seen& have_seen)
      : chance_(seed),
        rig_({.placement = "dx=0.3 mm", .seed = seed}),
        work_(work),
        judge_(rig_.machine()),
        have_seen_(have_seen) {
    owner().on_step([this] { step(); });
    undertake("bring_up", false, [this] { return owner().bring_up(); });
  }
  ~Episode() { owner().on_step({}); }
  Episode(const Episode&) = delete;
  Episode& operator=(const Episode&) = delete;

  int events = 0;
  std::string log{};  ///< what was done, for the one who reproduces it

  [[nodiscard]] const std::string& broken() const { return judge_.broken(); }

  /// Trouble until so many events have come, then the way out.
  void round(int how_many) {
    to_come_ = how_many;
    while (to_come_ > 0 && broken().empty()) {
      undertake_something();
      pass(chance_.below(400));
    }
    to_come_ = 0;
    if (broken().empty()) way_out();
  }

  /// The last one: a signal. What is under way ends, and nothing is undertaken any more.
  void signal() {
    signal_in_ = 1 + chance_.below(12'000);
    job();
    if (signal_in_ > 0) interrupt();
    signal_in_ = -1;
    if (owner().home() || owner().enable()) fail_with("something is undertaken after a signal");
    pass(200);
    owner().shut_down();
  }

 private:
  run::Owner& owner() { return rig_.owner(); }
  const Snapshot& now() { return owner().latest(); }
  void fail_with(const std::string& what) {
    note("broken: " + what);
    judge_.blame(now(), what);
  }
  void note(const std::string& what) {
    log += fmt::format("  {} {} {}: {}\n", now().cycle, cycle::name(now().state), std::string_view(code(now().latched)),
                       what);
  }

  // ---- every cycle ----

  void step() {
    const Snapshot& s = now();
    if (s.cycle == seen_) return;  // orders are polled while a block is planned, too: that depends on the wall clock
    seen_ = s.cycle;
    ++have_seen_.cycles[static_cast<std::size_t>(s.state)];
    if (s.latched != latched_ && s.latched != Fault::None) {
      ++have_seen_.latched[s.latched];
      note("is latched");
      if (info(s.latched).exit_code == ExitCode::Internal) fail_with("the program is stopped by what it did itself");
    }
    latched_ = s.latched;
    judge_.look(s);
    hear_reset();
    if (!broken().empty()) {  // there is nothing more to learn: out of here
      owner().interrupt(Error{Fault::Interrupted, "the judge has seen enough", ""});
      return;
    }
    if (signal_in_ > 0 && --signal_in_ == 0) interrupt();
    held_for_ = owner().held() ? held_for_ + 1 : 0;
    if (held_for_ > kLongestHold) order(chance_.one_of({OrderKind::Resume, OrderKind::Abort}), 1), held_for_ = 0;
    if (to_come_ > 0 && owner().undertaking() != Undertaking::BringUp && chance_.below(cycles_to_an_event_) == 0)
      event();
  }

  /// As a desk does: also what a button has asked for is answered.
  void hear_reset() {
    if (const auto answer = owner().reset_answer()) {
      note(*answer ? "reset: done" : "reset: " + to_text(answer->error()));
      if (asked_reset_at_ >= 0) reset_answer_ = answer;
      asked_reset_at_ = -1;
      judge_.reset_answered();
    } else if (asked_reset_at_ >= 0 && now().cycle > asked_reset_at_ + kResetAnswer) {
      fail_with("a reset has no answer");
    }
  }

  void interrupt() {
    note("interrupt");
    signal_in_ = 0;
    ++events;
    judge_.abort_taken(now().cycle);
    owner().interrupt(Error{Fault::Interrupted, "interrupted", ""});
  }

  /// What the desk makes of a client that is gone: a jog ends, everything else goes on without it.
  void client_dies() {
    note("client dies");
    if (owner().undertaking() != Undertaking::Jog) return;
    judge_.abort_taken(now().cycle);
    owner().interrupt(Error{Fault::Aborted, "the jog's client has closed its connection", ""});
  }

  void event() {
    --to_come_, ++events;
    if (chance_.below(5) < 3)
      random_order();
    else
      happening();
  }

  bool order(OrderKind kind, double value) {
    const bool busy = owner().undertaking() != Undertaking::None;
    const auto taken = owner().order({.kind = kind, .value = value});
    note(fmt::format("{}: {}", run::name(kind), taken ? "taken" : taken.error().message));
    if (kind == OrderKind::Abort && !taken) fail_with("an abort is refused");
    if (kind == OrderKind::Abort && busy) judge_.abort_taken(now().cycle);
    if (kind == OrderKind::Resume && taken) judge_.resume_taken();
    if (kind == OrderKind::Reset && taken) asked_reset_at_ = now().cycle, judge_.reset_taken();
    return taken.has_value();
  }

  void random_order() {
    switch (chance_.below(9)) {
      case 0:
      case 1: order(OrderKind::Hold, 1); break;
      case 2:
      case 3: order(OrderKind::Resume, 1); break;
      case 4: order(OrderKind::Abort, 1); break;
      case 5: order(OrderKind::Reset, 1); break;
      case 6: order(OrderKind::Override, chance_.one_of({0.1, 0.5, 1.0, 2.0})); break;
      case 7: client_dies(); break;
      default:
        if (owner().undertaking() == Undertaking::None) break;
        note("a second undertaking");
        if (owner().home() || owner().enable() || owner().disable() || owner().part_removed() || owner().park() ||
            owner().jog({.by = {{"X", "1 mm"}}}))
          fail_with("two undertakings at a time");
    }
  }

  // ---- the world ----

  void world(const std::string& yaml) {
    note(yaml);
    if (const auto added = owner().world()->add_script(yaml); !added) fail_with(to_text(added.error()));
  }
  /// Something now, and its opposite so much later.
  void for_a_while(const std::string& what, const std::string& opposite, CycleIndex cycles) {
    world(fmt::format("[{{do: {}}}, {{at: cycle {}, do: {}}}]", what, now().cycle + 2 + cycles, opposite));
  }
  std::uint32_t axis_bit(const std::string& name) {
    for (const config::Axis& axis : rig_.machine().axes)
      if (axis.name == name) return 1u << axis.id.value;
    return 0;
  }

  /// Axes whose drives leave the line with this station, or with the cable that leads to it.
  static std::uint32_t behind(std::string_view station) {
    constexpr std::uint32_t kX = 1, kY = 2, kZ = 4, kC = 8, kU = 16;
    if (station == "z") return kZ | kC | kU;
    if (station == "cu") return kC | kU;
    return station == "y1" || station == "y2" ? kY | kZ | kC | kU : kX | kY | kZ | kC | kU;
  }

  void happening() {
    const CycleIndex t = now().cycle;
    switch (chance_.below(16)) {
      case 0:
      case 1: {
        const std::string input = chance_.one_of({"door_closed", "air_ok", "safety_ok", "mode"});
        for_a_while(fmt::format("set_input, input: {}, on: false", input),
                    fmt::format("set_input, input: {}, on: true", input), chance_.one_of({1, 20, 500, 4000}));
        break;
      }
      case 2:
      case 3:
      case 4:
      case 5:
        world(fmt::format("{{do: press, input: {}, hold: {} ms}}", chance_.one_of({"stop", "hold", "start", "reset"}),
                          chance_.one_of({1, 50, 300})));
        break;
      case 6:
      case 7: {
        const std::string axis = chance_.one_of({"X", "Y", "Z", "C", "U"});
        judge_.torque_taken(axis_bit(axis), t + kAfterFault);
        world(fmt::format("{{do: drive_fault, axis: {}, drive: {}, code: {}}}", axis,
                          axis == "Y" ? chance_.below(2) : 0, chance_.one_of({"0x0E", "0x7500"})));
        break;
      }
      case 8: {
        const std::string axis = chance_.one_of({"X", "Y", "Z"});
        const CycleIndex held = chance_.one_of({5, 200, 2000});
        judge_.pushed(axis_bit(axis), t + held + kSpringsBack);
        for_a_while("stall, axis: " + axis, "release, axis: " + axis, held);
        break;
      }
      case 9:
      case 10: {
        const int count = chance_.one_of({1, 2, 3, 10, 60});
        const char* how = chance_.one_of({"lose_frames", "corrupt_frames", "duplicate_frames", "reorder_frames"});
        if (count >= 3) judge_.torque_taken(kAll, t + kAfterFault);
        world(fmt::format("{{do: {}, count: {}}}", how, count));
        break;
      }
      case 11: {
        const CycleIndex after = chance_.one_of({100, 1000, 4000});
        judge_.away(kAll, t + after + kAfterFault);
        for_a_while("emergency_stop", "emergency_release", after);
        break;
      }
      case 12: {
        const std::string station = chance_.one_of({"io", "x", "y1", "y2", "z", "cu"});
        const CycleIndex after = chance_.one_of({2, 50, 1000});
        judge_.away(behind(station), t + after + kAfterFault);
        for_a_while("cut_link, station: " + station, "heal_link, station: " + station, after);
        break;
      }
      case 13: {
        const std::string axis = chance_.one_of({"X", "Y", "Z"});
        const CycleIndex stuck = chance_.one_of({5, 300, 1500});
        judge_.away(axis_bit(axis), t + stuck + kAfterFault);  // what it reports is not so
        for_a_while("stick_statusword, axis: " + axis, "free_statusword, axis: " + axis, stuck);
        break;
      }
      case 14: for_a_while("camera_dead", "camera_alive", chance_.one_of({50, 1000})); break;
      default: {
        const std::string station = chance_.one_of({"x", "y1", "y2", "z", "cu"});
        const int dark_ms = chance_.one_of({20, 200, 1500});
        judge_.away(behind(station), t + dark_ms + kAfterFault);
        world(fmt::format("{{do: power_cycle, station: {}, dark: {} ms}}", station, dark_ms));
      }
    }
  }

  // ---- what takes machine time ----

  /// `moves`: an order that may move axes.
  Result<void> undertake(const std::string& name, bool moves, const std::function<Result<void>()>& what) {
    note(name);
    judge_.begins(moves, now().cycle);
    Result<void> done = what();
    judge_.ended();
    auto& [whole, otherwise] = have_seen_.ends[name.substr(0, name.find(' '))];
    ++(done ? whole : otherwise);
    note(name + ": " + (done ? "done" : to_text(done.error())));
    return done;
  }
  void job() {
    undertake("run", true, [this]() -> Result<void> {
      const auto result = owner().run(work_.recipe, work_.job, {});
      if (result.exit_code != ExitCode::Done)
        return tl::unexpected(result.errors.empty() ? Error{} : result.errors.front());
      return {};
    });
  }
  void jog() {
    const std::string axis = chance_.one_of({"X", "Y", "Z", "C", "U"});
    const int by = chance_.one_of({-30, -5, 2, 40});
    const std::string words = fmt::format("{} {}", by, axis == "C" ? "deg" : "mm");
    undertake("jog " + axis + " " + words, true, [&]() -> Result<void> {
      const auto done = owner().jog({.by = {{axis, words}}, .speed = axis == "C" ? "20 deg/s" : "50 mm/s"});
      if (!done) return tl::unexpected(done.error());
      return {};
    });
  }
  Result<void> enable() {
    auto done = undertake("enable", false, [this] { return owner().enable(); });
    if (done && now().latched == Fault::None && now().enabled != kAll) fail_with("enabled, and not all have torque");
    return done;
  }
  Result<void> home() {
    auto done = undertake("home", true, [this] { return owner().home(); });
    if (done && now().latched == Fault::None && now().referenced != kAll) fail_with("homed, and not referenced");
    return done;
  }
  void undertake_something() {
    cycles_to_an_event_ = chance_.one_of({25, 300, 1500});
    if (now().latched != Fault::None && chance_.below(4) != 0 && order(OrderKind::Reset, 1))
      for (int i = 0; i < 600 && asked_reset_at_ >= 0 && broken().empty(); ++i) pass(1);
    if (now().referenced != kAll && chance_.below(2) == 0) static_cast<void>(home());
    switch (chance_.below(10)) {
      case 0: static_cast<void>(home()); break;
      case 1: static_cast<void>(enable()); break;
      case 2: {
        const auto done = undertake("disable", false, [this] { return owner().disable(); });
        if (done && now().enabled != 0) fail_with("disabled, and a drive has torque");
        break;
      }
      case 3:
      case 4: jog(); break;
      case 5: undertake("part removed", false, [this] { return owner().part_removed(); }); break;
      case 6: undertake("park", true, [this] { return owner().park(); }); break;
      default: job();
    }
    if (owner().take_start()) job();
  }
  void pass(CycleIndex cycles) {
    for (const CycleIndex end = now().cycle + cycles; now().cycle < end && broken().empty();)
      if (const auto alive = owner().idle(); !alive) return fail_with(to_text(alive.error()));
  }

  // ---- out of it ----

  /// The world's part: everything as it should be. Then the operator's: reset, enable, home.
  void way_out() {
    judge_.torque_taken(kAll, now().cycle + kAfterFault);
    judge_.pushed(kAll, now().cycle + kSpringsBack);
    const CycleIndex give_up = now().cycle + kScriptIsOver + kSpringsBack + kBusComesBack;
    pass(kScriptIsOver);
    world("[{do: emergency_release}, {do: camera_alive}]");  // also what came a second time
    for (const char* axis : {"X", "Y", "Z"})
      world(fmt::format("[{{do: release, axis: {0}}}, {{do: free_statusword, axis: {0}}}]", axis));
    for (const char* input : {"door_closed", "air_ok", "safety_ok", "mode"})
      world(fmt::format("{{do: set_input, input: {}, on: true}}", input));
    for (const char* station : {"io", "x", "y1", "y2", "z", "cu"})
      world(fmt::format("{{do: heal_link, station: {}}}", station));
    judge_.pushed(kAll, now().cycle + kSpringsBack);
    pass(kSpringsBack);
    while (!(now().al_states == 8 && now().working_counter == now().expected) && broken().empty()) {
      if (now().cycle > give_up)
        return fail_with(fmt::format("the bus does not come back: working counter {} of {}, states {:02X}h",
                                     now().working_counter, now().expected, now().al_states));
      pass(10);
    }
    pass(100);
    for (int times = 1;; ++times) {
      if (!order(OrderKind::Reset, 1)) return fail_with("no way out: reset is refused");
      while (asked_reset_at_ >= 0 && broken().empty()) pass(1);
      if (reset_answer_ && !*reset_answer_) return fail_with("no way out: reset: " + to_text(reset_answer_->error()));
      if (const auto done = enable(); !done) return fail_with("no way out: enable: " + to_text(done.error()));
      const auto done = home();
      if (done) break;
      // What was led a part of its way is led on by the next one (docs/commissioning.md).
      const bool nearer = done.error().fault == Fault::GantrySkew || done.error().fault == Fault::HomingSwitchStuck;
      if (!nearer || times >= kMostTimes) return fail_with("no way out: home: " + to_text(done.error()));
    }
    if (now().state != State::Ready || now().latched != Fault::None) fail_with("no way out: not ready after home");
  }

  Chance chance_;
  test::Rig rig_;
  const Work& work_;
  test::Judge judge_;
  Seen& have_seen_;
  Fault latched_ = Fault::None;
  std::optional<Result<void>> reset_answer_;
  CycleIndex seen_ = -1, asked_reset_at_ = -1, held_for_ = 0;
  int to_come_ = 0, signal_in_ = -1, cycles_to_an_event_ = 100;
};

/// 217: one side of the beam began to home without the other one, and racked it. 337: one side lost its supply while
/// the beam moved, and left it racked beyond what homing takes out at a time. 650: one side had left the line, and the
/// other one was braked by targets. 200443: frames were lost, and both leapt after the first that came through. 720242:
/// one side lost its supply at 300 mm/s, and an emergency stop came a cycle later. 830868: a disable took the torque of
/// an axis that still settled behind lost frames. 831015: targets followed an axis that somebody let go, as long as its
/// drive called itself enabled.
constexpr std::array<std::uint64_t, 7> kFoundSomething{217, 337, 650, 200443, 720242, 830868, 831015};

TEST(EventFuzz, stops_hold_valves_shut_and_verbs_lead_out_whatever_comes) {
  constexpr int kRounds = 3, kEventsOfARound = 25;
  const int most = static_cast<int>(number_of("GANTRY_FUZZ_EVENTS", 1500));
  const std::uint64_t first = number_of("GANTRY_FUZZ_SEED", 1);
  const bool all = std::getenv("GANTRY_FUZZ_GO_ON") != nullptr;  // past the first failure
  if (std::getenv("GANTRY_FUZZ_SAY") == nullptr)
    spdlog::set_level(spdlog::level::off);  // thousands of faults, each told
  const auto machine = config::load_machine("config/machines/dispenser.yaml");
  ASSERT_TRUE(machine);
  Work work{test::load_recipe("tests/cli/short-board.yaml"), {}};
  const auto job = recipes::compile(work.recipe, *machine);
  ASSERT_TRUE(job);
  work.job = *job;
  const auto play = [](Episode& episode) {
    for (int r = 0; r < kRounds && episode.broken().empty(); ++r) episode.round(kEventsOfARound);
  };
  int events = 0;
  Seen seen;
  for (const std::uint64_t seed : kFoundSomething) {
    Episode episode(seed, work, seen);
    play(episode);
    EXPECT_TRUE(episode.broken().empty()) << "seed " << seed << ": " << episode.broken() << "\n" << episode.log;
  }
  std::uint64_t seed = first;
  for (; events < most; ++seed) {
    Episode episode(seed, work, seen);
    play(episode);
    if (episode.broken().empty() && seed % 4 == 0) episode.signal();
    events += std::max(episode.events, 1);
    if (episode.broken().empty()) continue;
    ADD_FAILURE() << "seed " << seed << ": " << episode.broken();
    if (!all) FAIL() << "GANTRY_FUZZ_SEED=" << seed << " GANTRY_FUZZ_EVENTS=1\n" << episode.log;
  }
  fmt::print("{} events, seeds {} to {}\n{}\n", events, first, seed - 1, seen.said());
  if (most < 1000) return;
  for (std::size_t i = 0; i < seen.cycles.size(); ++i)
    EXPECT_GT(seen.cycles[i], 0) << cycle::name(static_cast<State>(i));
  for (const char* what : {"run", "jog", "home", "enable", "park"}) {
    EXPECT_GT(seen.done(what), 0) << what;
    EXPECT_GT(seen.ended(what), 0) << what;
  }
  EXPECT_GE(seen.latched.size(), 8u) << "kinds of faults that stopped the machine";
}

}  // namespace
}  // namespace gantry
