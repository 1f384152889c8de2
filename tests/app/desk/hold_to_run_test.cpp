// A jog stands within 100 ms of its client's last word: every axis, as fast as a jog goes, at short and long cycles,
// and wherever in the jog the client falls silent.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

constexpr double kStands_mm = 0.005, kStands_rad = 0.0005;  ///< so near to where it stays it stands
constexpr Time kBeat = milliseconds(5);

class HoldToRun : public Desks, public ::testing::WithParamInterface<std::chrono::microseconds> {
 protected:
  void change(config::Machine& machine) const override {
    machine.bus.cycle = GetParam();
    machine.override_max = 2;
    for (config::Axis& axis : machine.axes)
      axis.response_delay_s = std::max(axis.response_delay_s, 1.3 * seconds(machine.bus.cycle));
    for (config::Station& station : machine.stations)
      if (station.profile.drive) station.profile.drive->cycle_times_us.push_back(static_cast<int>(GetParam().count()));
  }

  struct Seen {
    Time at{};
    AxisVec target{}, actual{};
  };
  struct Jogged {
    Time begins{}, ends{};  ///< from the order to the first target that moves, and to standstill
    Time silent{};          ///< from the last word to standstill
    Json answer;
  };

  /// From when on everything stands where it stays.
  [[nodiscard]] Time stands_from(const std::vector<Seen>& seen) const {
    Time from = seen.back().at;
    for (auto s = seen.rbegin(); s != seen.rend(); ++s) {
      bool there = s->target == seen.back().target;
      for (const config::Axis& axis : machine_.axes)
        there = there && std::abs(s->actual[axis.id.value] - seen.back().actual[axis.id.value]) <=
                             (axis.rotary ? kStands_rad : kStands_mm);
      if (!there) break;
      from = s->at;
    }
    return from;
  }

  /// A jog from drives without torque, whose client says its last word `last` after the order; nothing: it speaks on.
  Jogged jog(const std::string& by, std::optional<Time> last, const std::string& speed = "1e6 mm/s") {
    order("disable");
    heard_.clear();
    const int id = ++id_;
    const Time from = clock_.now() + machine_.bus.cycle;
    std::optional<Time> spoken;
    std::vector<Seen> seen;
    on_cycle_ = [&] {
      const cycle::Snapshot& now = owner_->latest();
      seen.push_back({clock_.now(), now.target, now.actual});
      if (heard_.ends_with('\n') && !answered(id)) heard_.clear();  // what a sign of life is answered
      if (spoken && (clock_.now() - *spoken < kBeat || (last && clock_.now() - from > *last))) return;
      client_->say(spoken ? "{\"order\":\"status\"}\n"
                          : fmt::format(R"({{"order":"jog","id":{},"by":{},"speed":"{}"}})", id, by, speed) + "\n");
      spoken = clock_.now();
    };
    serve_until(id, static_cast<int>(milliseconds(150) / machine_.bus.cycle));
    Jogged jogged{.answer = answer(id)};
    const auto begun = std::ranges::find_if(seen, [&](const Seen& s) { return s.target != seen.front().target; });
    if (begun == seen.end()) return jogged;
    jogged.begins = begun->at - from;
    jogged.ends = stands_from(seen) - from;
    // A word is said up to a cycle before it is read.
    jogged.silent = stands_from(seen) - *spoken + machine_.bus.cycle;
    return jogged;
  }
  void order(const std::string& name, const std::string& more = "") {
    const int id = ++id_;
    client_->say(fmt::format(R"({{"order":"{}","id":{}{}}})", name, id, more) + "\n");
    serve_until(id);
    EXPECT_TRUE(answer(id).value("ok", false)) << answer(id).dump();
  }

  int id_ = 100;
};

struct There {
  std::string by, back;
  std::string unit = "mm/s";
};
const std::array kJogs{There{R"({"X":"9 mm"})", R"({"X":"-9 mm"})"},
                       There{R"({"Y":"9 mm"})", R"({"Y":"-9 mm"})"},
                       There{R"({"Z":"-9 mm"})", R"({"Z":"9 mm"})"},
                       There{R"({"C":"9 deg"})", R"({"C":"-9 deg"})", "deg/s"},
                       There{R"({"U":"3 mm"})", R"({"U":"-3 mm"})"},
                       There{R"({"X":"5 mm","Y":"7 mm","Z":"-4 mm","C":"8 deg","U":"2 mm"})",
                             R"({"X":"-5 mm","Y":"-7 mm","Z":"4 mm","C":"-8 deg","U":"-2 mm"})"}};

TEST_P(HoldToRun, every_axis_stands_within_100_ms_of_the_last_word_wherever_its_client_falls_silent) {
  home();
  const std::string inside = R"({"X":"22 mm","Y":"22 mm","Z":"-20 mm","U":"5 mm","C":"20 deg"})";
  ASSERT_TRUE(jog(inside, {}, "20 mm/s").answer.value("ok", false));
  order("override", ",\"value\":2");  // makes no jog faster
  for (const There& there : kJogs) {
    const Jogged whole = jog(there.by, {}, "1e6 " + there.unit);
    ASSERT_TRUE(whole.answer.value("ok", false)) << whole.answer.dump();
    EXPECT_NE(whole.answer.value("slowed", "").find("within 100 ms of its client's last word"), std::string::npos)
        << whole.answer.dump();
    ASSERT_TRUE(jog(there.back, {}, "1e6 " + there.unit).answer.value("ok", false));
    // The silence is seen while it gets faster, and at its full speed.
    for (const int last_ms : {-9, -5, -1, 40}) {
      const Jogged cut = jog(there.by, whole.begins + milliseconds(last_ms), "1e6 " + there.unit);
      EXPECT_EQ(code_of(cut.answer), "G701") << cut.answer.dump();
      EXPECT_LE(cut.silent, milliseconds(100)) << there.by << ", last word " << last_ms;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Cycles, HoldToRun,
                         ::testing::Values(std::chrono::microseconds(250), std::chrono::microseconds(1000),
                                           std::chrono::microseconds(4000), std::chrono::microseconds(10'000)),
                         [](const auto& cycle) { return std::to_string(cycle.param.count()) + "_us"; });

}  // namespace
}  // namespace gantry::desk
