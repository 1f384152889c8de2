// What happens to the machine from without while its desk serves: a script's events, the door, the safety chain, a
// button.
#include <algorithm>

#include "tests/app/desk/desks.hpp"

namespace gantry::desk {
namespace {

class AScriptForLater : public Desks {
  std::string script() const override {
    return "- {at: cycle 90000000, do: lose_frames, count: 3}\n"
           "- {at: job start, after: 900 s, do: camera_dead}";
  }
};

/// What is planned for a later cycle may still come while the owner lives on; what the first
/// job's start was to lead to has not come in it.
TEST_F(AScriptForLater, is_not_told_as_missed_after_every_job) {
  const auto missed = [&](int id) {
    client_->say(run_order(id, std::to_string(id)));
    serve_until(id);
    EXPECT_TRUE(answer(id).value("ok", false)) << answer(id).dump();
    std::ifstream file(folder_ / std::to_string(id) / "summary.json");
    std::vector<std::string> told;
    const Json summary = Json::parse(file);
    for (const auto& event : summary["events"])
      if (event.get<std::string>().find("did not happen") != std::string::npos) told.push_back(event);
    return told;
  };
  const auto first = missed(1);
  ASSERT_EQ(first.size(), 1u);
  EXPECT_NE(first[0].find("camera_dead at job start"), std::string::npos) << first[0];
  EXPECT_TRUE(missed(2).empty());
}

class ADoorThatOpens : public Desks {
  std::string script() const override {
    return "- {at: cycle 2000, do: set_input, input: door_closed, on: false}\n"
           "- {at: cycle 6000, do: set_input, input: door_closed, on: true}";
  }
};

TEST_F(ADoorThatOpens, latches_until_a_reset_has_looked_whether_it_is_shut) {
  client_->say("{\"order\":\"enable\",\"id\":5}\n");  // without torque a door may be open
  bool early = false, late = false;
  on_cycle_ = [&] {
    const CycleIndex now = owner_->latest().cycle;
    if (!early && now > 2500)
      early = client_->say("{\"order\":\"status\",\"id\":1}\n{\"order\":\"reset\",\"id\":2}\n") > 0;
    if (!late && now > 7000)
      late = client_->say("{\"order\":\"reset\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n") > 0;
  };
  serve_until(3, 10);
  ASSERT_FALSE(answer(1)["faults"].empty()) << heard_;
  EXPECT_EQ(answer(1)["faults"][0].value("code", ""), std::string(std::string_view(code(Fault::DoorOpen))));
  EXPECT_FALSE(answer(1)["faults"][0].value("remedy", "").empty());
  EXPECT_FALSE(answer(2).value("ok", true)) << "the door is open";
  EXPECT_TRUE(answer(3).value("ok", false)) << answer(3).dump();
  EXPECT_TRUE(answer(3)["faults"].empty()) << "it is answered when it is done";
  EXPECT_EQ(answer(3).value("state", ""), "ready");
}

class ADoorAndTheSafetyChain : public Desks {
  std::string script() const override {
    return "- {at: cycle 2000, do: set_input, input: door_closed, on: false}\n"
           "- {at: cycle 2500, do: set_input, input: air_ok, on: false}\n"
           "- {at: cycle 3000, do: set_input, input: safety_ok, on: false}\n"
           "- {at: cycle 6000, do: set_input, input: door_closed, on: true}\n"
           "- {at: cycle 6000, do: set_input, input: safety_ok, on: true}";
  }
};

TEST_F(ADoorAndTheSafetyChain, are_all_told_by_status_also_those_that_came_behind_the_latched_one) {
  client_->say("{\"order\":\"enable\",\"id\":5}\n");
  int asked = 0;
  on_cycle_ = [&] {
    const CycleIndex now = owner_->latest().cycle;
    if (asked == 0 && now > 2900) asked = client_->say("{\"order\":\"status\",\"id\":1}\n") > 0 ? 1 : 0;
    if (asked == 1 && now > 4000) asked = client_->say("{\"order\":\"status\",\"id\":2}\n") > 0 ? 2 : 1;
    if (asked == 2 && now > 7000)
      asked = client_->say("{\"order\":\"reset\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n") > 0 ? 3 : 2;
  };
  const auto told = [&](int id) {
    const Json status = answer(id);
    std::vector<std::string> codes;
    for (const auto& fault : status.value("faults", Json::array())) codes.push_back(fault.value("code", ""));
    return codes;
  };
  serve_until(4, 10);
  using Codes = std::vector<std::string>;
  EXPECT_EQ(told(1), (Codes{"G704", "G705"})) << "the door is latched; air is missing, too";
  EXPECT_EQ(told(2), (Codes{"G712", "G704", "G705"})) << "no job outlives it: it takes the door's place";
  EXPECT_FALSE(answer(3).value("ok", true)) << "air is still missing";
  EXPECT_EQ(told(4), (Codes{"G705"}));
}

class AStartButton : public Desks {
  std::string script() const override {
    return "- {at: cycle 3000, do: press, input: start}\n"
           "- {at: cycle 60000, do: set_input, input: mode, on: false}\n"
           "- {at: cycle 61000, do: press, input: start, hold: 100 ms}";
  }
};

TEST_F(AStartButton, runs_the_recipe_of_the_desk_and_in_setup_nothing) {
  std::size_t done = 0;
  std::string mode;
  std::filesystem::current_path(folder_);  // results go to out/ where the owner stands
  bool asked = false, moved_in_setup = false;
  const auto told = [&](int n) {
    return std::filesystem::exists(folder_ / "out" / ("short-board-00" + std::to_string(n)) / "summary.json");
  };
  int refused = 0;  // times, as far as their folders tell
  CycleIndex pressed_at = 61'000;
  on_cycle_ = [&] {
    const auto& s = owner_->latest();
    if (refused < 3 && s.cycle > pressed_at + 300 && told(2 + refused) && ++refused < 3) {
      ASSERT_TRUE(owner_->world()->add_script("{do: press, input: start, hold: 100 ms}").has_value());
      pressed_at = s.cycle;
    }
    done = std::max(done, owner_->progress().features_done);
    if (s.cycle > 60'100 && owner_->in_setup() && s.state == cycle::State::Running) moved_in_setup = true;
    if (asked || s.cycle <= 63'000 || refused < 3) return;
    client_ = std::make_unique<Peer>(folder_ / "owner.sock");  // the first one was idle for too long
    heard_.clear();
    asked = client_->say("{\"order\":\"status\",\"id\":1}\n") > 0;
  };
  serve_until(1);
  std::filesystem::current_path(source_);
  EXPECT_EQ(done, 3u);
  EXPECT_FALSE(moved_in_setup);
  EXPECT_EQ(answer(1).value("mode", ""), "setup");
  const auto result_of = [&](const char* folder) {
    std::ifstream file(folder_ / "out" / folder / "summary.json");
    return file ? Json::parse(file).value("result", "") : std::string("none");
  };
  EXPECT_EQ(result_of("short-board-001"), "done");
  EXPECT_EQ(result_of("short-board-004"), "failed") << "of the same mistake three times the newest folder is left";
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "short-board-002"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out" / "short-board-003"));
}

}  // namespace
}  // namespace gantry::desk
