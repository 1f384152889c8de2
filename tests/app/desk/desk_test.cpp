// The desk over a whole machine in virtual time; clients speak through the socket, and their clock is the test's.
#include "app/desk/desk.hpp"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/desk/answer.hpp"
#include "tests/app/desk/peer.hpp"

namespace gantry::desk {
namespace {

using test::Peer;

constexpr const char* kShort = "tests/cli/short-board.yaml";

class Desks : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("gantry-desk-" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    auto machine = config::load_machine("config/machines/dispenser.yaml");
    ASSERT_TRUE(machine);
    machine_ = std::move(*machine);
    run::OwnerOptions options;
    options.virtual_time = true;
    if (!script().empty()) {
      std::ofstream(folder_ / "script.yaml") << script();
      options.sim.script_file = folder_ / "script.yaml";
    }
    auto owner = run::Owner::open(machine_, options);
    ASSERT_TRUE(owner) << to_text(owner.error());
    owner_ = std::move(*owner);
    door_ = std::move(*OrderSocket::listen(folder_ / "owner.sock", is_urgent));
    make_desk();
    owner_->on_step([this] { step(); });
    ASSERT_TRUE(desk_->bring_up());
    client_ = std::make_unique<Peer>(folder_ / "owner.sock");
  }
  void TearDown() override {
    owner_->on_step({});
    owner_.reset();
    door_.reset();
    std::filesystem::remove_all(folder_);
  }
  /// What happens to the machine from without.
  [[nodiscard]] virtual std::string script() const { return ""; }
  /// Where parts are remembered; null: nowhere.
  [[nodiscard]] virtual BegunParts* parts() { return nullptr; }
  void make_desk() {
    desk_ = std::make_unique<Desk>(
        machine_, *owner_, *door_, clock_,
        Desk::Options{
            .interrupted = [] { return false; }, .recipe = std::filesystem::absolute(kShort), .parts = parts()});
  }
  /// Each cycle is a millisecond for the clients too.
  void step() {
    clock_.sleep_until(clock_.now() + milliseconds(1));
    ++steps_;
    if (client_) heard_ += client_->hear();
    if (on_cycle_) on_cycle_();
    desk_->poll();
    const double x = owner_->latest().target[0];
    if (x != last_x_) moved_at_ = steps_;
    last_x_ = x;
  }
  /// The answer with this id, if it has come.
  [[nodiscard]] Json answer(int id) const {
    for (std::size_t at = 0; at < heard_.size();) {
      const std::size_t end = std::min(heard_.find('\n', at), heard_.size());
      const Json line = Json::parse(heard_.substr(at, end - at), nullptr, false);
      if (line.is_object() && line.value("id", 0) == id) return line;
      at = end + 1;
    }
    return {};
  }
  [[nodiscard]] bool answered(int id) const { return !answer(id).is_null(); }
  /// Serves until `id` is answered, and `cycles` more.
  void serve_until(int id, int cycles = 0) {
    const auto asked = on_cycle_;
    int left = 200'000, more = cycles;
    on_cycle_ = [&, asked] {
      if (asked) asked();
      if (!answered(id) && --left > 0) return;
      if (more-- == 0) Peer(folder_ / "owner.sock").say("{\"order\":\"quit\"}\n");
    };
    EXPECT_TRUE(desk_->serve());
    on_cycle_ = {};
    if (client_) heard_ += client_->hear();
    make_desk();
  }
  void home() {
    client_->say("{\"order\":\"home\",\"id\":1}\n");
    serve_until(1);
    ASSERT_TRUE(answer(1).value("ok", false)) << heard_;
  }

  std::filesystem::path folder_, source_ = std::filesystem::current_path();
  config::Machine machine_;
  VirtualClock clock_;
  std::unique_ptr<run::Owner> owner_;
  std::unique_ptr<OrderSocket> door_;
  std::unique_ptr<Desk> desk_;
  std::unique_ptr<Peer> client_;
  std::string heard_;
  std::function<void()> on_cycle_;
  int steps_ = 0, moved_at_ = 0;
  double last_x_ = 0;
};

std::string code_of(const Json& answer) {
  const auto errors = errors_of(answer);
  return errors.empty() ? "" : std::string(std::string_view(code(errors.front().fault)));
}

TEST_F(Desks, an_abort_cancels_an_order_that_waits) {
  client_->say("{\"order\":\"home\",\"id\":1}\n");
  step();
  Peer other(folder_ / "owner.sock");
  other.say("{\"order\":\"abort\",\"id\":2}\n");
  std::string heard;
  for (int i = 0; i < 30 && heard.empty(); ++i) step(), heard += other.hear();
  EXPECT_NE(heard.find("\"ok\":true"), std::string::npos) << heard;
  serve_until(1, 2000);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
}

TEST_F(Desks, an_abort_cancels_a_job_that_is_prepared_and_nothing_moves_afterwards) {
  const std::string recipe = std::filesystem::absolute("recipes/demo-board.yaml");
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"" + recipe + "\",\"out\":\"" + (folder_ / "job").string() +
               "\"}\n");
  bool sent = false;
  on_cycle_ = [&] {
    if (!sent && steps_ > 30) sent = client_->say("{\"order\":\"abort\",\"id\":2}\n") > 0;
  };
  client_->say("{\"order\":\"abort\",\"id\":3}\n");  // behind it in one turn: it waits already
  serve_until(1, 3000);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  EXPECT_FALSE(std::filesystem::exists(folder_ / "job"));
  EXPECT_EQ(owner_->latest().state, cycle::State::Disabled);
}

/// While a job is prepared the owner does not know it yet.
TEST_F(Desks, a_hold_while_a_job_is_prepared_lets_it_wait_before_its_first_motion) {
  const std::string recipe = std::filesystem::absolute(kShort);
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"" + recipe + "\",\"out\":\"" + (folder_ / "job").string() +
               "\"}\n");
  const int begin = steps_;
  bool asked = false, moved = false;
  int waits = 0;
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"hold\",\"id\":2}\n{\"order\":\"status\",\"id\":3}\n") > 0;
    const auto& s = owner_->latest();
    if (waits <= 3000) moved = moved || s.block != 0;
    if (owner_->undertaking() == run::Undertaking::Job && owner_->state() == cycle::State::Held) ++waits;
    if (waits == 3000) client_->say("{\"order\":\"resume\",\"id\":4}\n"), ++waits;
  };
  serve_until(1);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_NE(answer(2).dump().find("waits before its first motion"), std::string::npos) << answer(2).dump();
  EXPECT_TRUE(answer(3).value("held", false)) << answer(3).dump();
  EXPECT_GT(waits, 3000) << "the machine homes, and then waits";
  EXPECT_FALSE(moved);
  EXPECT_TRUE(answer(4).value("ok", false)) << answer(4).dump();
  EXPECT_EQ(answer(1).value("result", ""), "done") << answer(1).dump();
}

TEST_F(Desks, a_hold_of_a_job_that_is_prepared_is_taken_back_by_a_resume_and_forgotten_by_an_abort) {
  const std::string recipe = std::filesystem::absolute(kShort);
  const auto run = [&](int id) {
    return "{\"order\":\"run\",\"id\":" + std::to_string(id) + ",\"recipe\":\"" + recipe + "\",\"out\":\"" +
           (folder_ / ("job" + std::to_string(id))).string() + "\"}\n";
  };
  client_->say(run(1));
  int begin = steps_;
  bool asked = false, held = false;
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"override\",\"value\":0,\"id\":2}\n{\"order\":\"abort\",\"id\":3}\n") > 0;
  };
  serve_until(1);
  EXPECT_EQ(code_of(answer(1)), "G701") << heard_;
  asked = false;
  begin = steps_;
  client_->say(run(4));
  on_cycle_ = [&] {
    if (!asked && steps_ > begin + 3)
      asked = client_->say("{\"order\":\"hold\",\"id\":5}\n{\"order\":\"resume\",\"id\":6}\n") > 0;
    held = held || owner_->held();
  };
  serve_until(4);
  EXPECT_TRUE(answer(6).value("ok", false)) << answer(6).dump();
  EXPECT_FALSE(held);
  EXPECT_EQ(answer(4).value("result", ""), "done") << answer(4).dump();
}

TEST_F(Desks, a_job_is_answered_in_short_and_told_in_its_folder) {
  const std::string recipe = std::filesystem::absolute(kShort);
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"" + recipe + "\",\"out\":\"" + (folder_ / "job").string() +
               "\"}\n");
  serve_until(1);
  const Json done = answer(1);
  EXPECT_TRUE(done.value("ok", false)) << heard_;
  EXPECT_EQ(done.value("order", ""), "run");
  EXPECT_EQ(done.value("result", ""), "done");
  EXPECT_EQ(done.value("exit_code", -1), 0);
  EXPECT_EQ(done.value("folder", ""), (folder_ / "job").string());
  EXPECT_NE(done.value("said", "").find("3 of 3 features"), std::string::npos);
  EXPECT_LT(done.dump().size(), kLongestAnswer);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "job/summary.json"));
}

TEST_F(Desks, a_recipe_that_cannot_be_read_is_told_as_such) {
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"/none/board.yaml\"}\n");
  serve_until(1);
  EXPECT_NE(heard_.find("the owner, which runs as user"), std::string::npos) << heard_;
  EXPECT_EQ(errors_of(answer(1)).front().where, "/none/board.yaml");
}

TEST_F(Desks, a_thousand_mistakes_fit_into_an_answer) {
  std::vector<Error> errors(1000, Error{Fault::Usage, std::string(10'000, 'e'), "there"});
  const Json answer = failure(errors);
  EXPECT_LT(to_line(answer).size(), kLongestAnswer);
  EXPECT_EQ(answer["errors"].size() + answer["errors_left_out"].get<std::size_t>(), 1000u);
}

TEST_F(Desks, a_jog_goes_on_while_its_client_speaks) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"10 mm\"},\"speed\":\"20 mm/s\"}\n");
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  const double before = owner_->latest().target[0];
  serve_until(2);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  EXPECT_NEAR(owner_->latest().target[0] - before, 10, 1e-6);
}

TEST_F(Desks, a_jog_that_goes_slower_than_it_was_asked_for_says_so) {
  home();
  on_cycle_ = [&] {
    if (steps_ % 25 == 0) client_->say("{\"order\":\"status\",\"id\":9}\n");
  };
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"10 mm\"},\"speed\":\"1e9 mm/s\"}\n");
  serve_until(2);
  EXPECT_EQ(answer(2).value("slowed", ""), "no faster than 500 mm/s, because axis X can do 500.000 mm/s")
      << answer(2).dump();
  EXPECT_NE(answer(2).value("said", "").find("; no faster than 500 mm/s"), std::string::npos) << answer(2).dump();
  client_->say("{\"order\":\"jog\",\"id\":3,\"by\":{\"X\":\"1 mm\"},\"speed\":\"20 mm/s\"}\n");
  serve_until(3);
  EXPECT_FALSE(answer(3).contains("slowed")) << answer(3).dump();
}

TEST_F(Desks, a_jog_ends_when_its_client_is_silent) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"100 mm\"},\"speed\":\"20 mm/s\"}\n");
  int last_word = 0;
  const int begin = steps_;
  on_cycle_ = [&] {
    if (steps_ % 25 != 0 || steps_ > begin + 1000) return;
    client_->say("{\"order\":\"status\",\"id\":9}\n");
    last_word = steps_;
  };
  const double before = owner_->latest().target[0];
  serve_until(2, 500);
  EXPECT_EQ(code_of(answer(2)), "G701") << heard_;
  EXPECT_NE(answer(2).dump().find("silent for 60 ms"), std::string::npos);
  EXPECT_GT(owner_->latest().target[0], before + 5);
  EXPECT_LE(moved_at_ - last_word, 100) << "it stands within 100 ms";
  EXPECT_GT(moved_at_ - last_word, 60);
}

TEST_F(Desks, a_jog_ends_when_its_client_is_gone) {
  home();
  client_->say("{\"order\":\"jog\",\"id\":2,\"by\":{\"X\":\"100 mm\"},\"speed\":\"20 mm/s\"}\n");
  const int begin = steps_;
  int gone = 0;
  on_cycle_ = [&] {
    if (steps_ < begin + 500 && steps_ % 25 == 0) client_->say("{\"order\":\"status\"}\n");
    if (gone == 0 && steps_ == begin + 500) client_.reset(), gone = steps_;
    if (steps_ == begin + 1500) Peer(folder_ / "owner.sock").say("{\"order\":\"quit\"}\n");
  };
  EXPECT_TRUE(desk_->serve());
  EXPECT_GT(moved_at_, gone);
  EXPECT_LE(moved_at_ - gone, 40);
}

TEST_F(Desks, parking_is_answered_when_the_head_stands_there_and_needs_no_sign_of_life) {
  home();
  client_->say("{\"order\":\"park\",\"id\":2}\n");
  bool asked = false;
  on_cycle_ = [&] {
    if (!asked && owner_->latest().state == cycle::State::Running)
      asked = client_->say("{\"order\":\"home\",\"id\":3}\n{\"order\":\"status\",\"id\":4}\n") > 0;
  };
  serve_until(2);
  EXPECT_TRUE(answer(2).value("ok", false)) << answer(2).dump();
  for (const auto& [axis, position] : machine_.park)
    EXPECT_NEAR(owner_->latest().target[axis.value], position, 1e-6) << axis.value;
  EXPECT_EQ(code_of(answer(3)), "G702");
  EXPECT_NE(answer(3).dump().find("'park'"), std::string::npos);
  EXPECT_EQ(answer(4).value("busy_with", ""), "park");
}

TEST_F(Desks, a_job_goes_on_without_its_client) {
  const std::string recipe = std::filesystem::absolute(kShort);
  client_->say("{\"order\":\"run\",\"id\":1,\"recipe\":\"" + recipe + "\",\"out\":\"" + (folder_ / "job").string() +
               "\"}\n");
  int left = 400'000;
  on_cycle_ = [&] {
    if (client_ && owner_->latest().block > 0) client_.reset();
    if (std::filesystem::exists(folder_ / "job/summary.json") || --left == 0)
      Peer(folder_ / "owner.sock").say("{\"order\":\"quit\"}\n");
  };
  EXPECT_TRUE(desk_->serve());
  EXPECT_FALSE(client_);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "job/summary.json"));
}

TEST_F(Desks, a_second_order_that_takes_time_is_refused_and_the_answer_names_the_first) {
  client_->say("{\"order\":\"home\",\"id\":1}\n{\"order\":\"enable\",\"id\":2}\n");
  serve_until(1);
  EXPECT_TRUE(answer(1).value("ok", false));
  EXPECT_EQ(code_of(answer(2)), "G702");
  EXPECT_NE(answer(2).dump().find("'home'"), std::string::npos);
}

TEST_F(Desks, status_tells_mode_and_faults_and_the_clamp_opens_by_an_order) {
  client_->say("{\"order\":\"status\",\"id\":1}\n{\"order\":\"part_removed\",\"id\":2}\n");
  serve_until(2);
  EXPECT_EQ(answer(1).value("mode", ""), "automatic");
  EXPECT_EQ(answer(1).value("held", true), false);
  EXPECT_TRUE(answer(1)["faults"].empty());
  EXPECT_TRUE(answer(2).value("ok", false)) << heard_;
  EXPECT_EQ(owner_->latest().outputs & config::bit(config::Output::Clamp), 0u);
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

/// The first bead of the first job is cut by the stop button.
class APartThatIsCut : public Desks {
 protected:
  std::string script() const override {
    return "- {at: feature bead 1, after: 300 ms, do: press, input: stop, hold: 100 ms}";
  }
  BegunParts* parts() override { return &*parts_; }
  void SetUp() override {
    parts_.emplace((std::filesystem::temp_directory_path() / ("gantry-parts-" + std::to_string(getpid()))).string());
    Desks::SetUp();
  }
  void TearDown() override {
    Desks::TearDown();
    std::filesystem::remove_all(kept());
  }
  [[nodiscard]] std::filesystem::path kept() const {
    return std::filesystem::temp_directory_path() / ("gantry-parts-" + std::to_string(getpid()));
  }
  /// Files about parts.
  [[nodiscard]] std::size_t remembered() const {
    std::size_t n = 0;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(kept(), ignored))
      n += entry.path().filename().string().starts_with("part") ? 1u : 0u;
    return n;
  }
  /// UTC of its only part.
  static std::string began_in(const std::filesystem::path& folder) {
    std::ifstream file(folder / "part.json");
    return Json::parse(file, nullptr, false).value("began", "");
  }
  [[nodiscard]] bool clamped() const { return (owner_->latest().outputs & config::bit(config::Output::Clamp)) != 0; }
  Json ask(Json order) {
    order["id"] = ++id_;
    client_->say(order.dump() + "\n");
    serve_until(id_);
    return answer(id_);
  }
  Json run(const Json& more = Json::object(), const std::string& recipe = kShort) {
    Json order{{"order", "run"},
               {"recipe", std::filesystem::absolute(recipe).string()},
               {"out", (folder_ / "job").string()},
               {"force", true}};
    order.update(more);
    return ask(order);
  }
  /// The first job: it is stopped in its bead, and given up.
  void cut(const Json& more = Json::object()) {
    bool given_up = false;
    on_cycle_ = [&, asked = on_cycle_] {
      if (asked) asked();
      if (given_up || !owner_->stopped()) return;
      client_->say("{\"order\":\"abort\"}\n");
      given_up = true;
    };
    const Json first = run(more);
    on_cycle_ = {};
    ASSERT_EQ(code_of(first), "G701") << first.dump();
    for (int i = 0; i < 200; ++i) EXPECT_TRUE(owner_->idle());  // the button is up again
    EXPECT_EQ(first.value("board", ""), "begun");
    EXPECT_EQ(first.value("to_finish", ""), "--only corner");
    EXPECT_NE(first.value("said", "").find("cut            'corner'"), std::string::npos) << first.value("said", "");
    EXPECT_NE(first.value("said", "").find("short-board.yaml --only corner"), std::string::npos);
    ASSERT_TRUE(ask({{"order", "reset"}}).value("ok", false));
    EXPECT_EQ(remembered(), 1u);
  }
  void expect_refused(const Json& answer, const std::vector<std::string>& words) {
    EXPECT_EQ(code_of(answer), "G702") << answer.dump();
    EXPECT_EQ(answer.value("exit_code", 0), 7);
    EXPECT_EQ(answer.value("board", ""), "begun");
    for (const std::string& word : words)
      EXPECT_NE(answer.dump().find(word), std::string::npos) << word << answer.dump();
  }
  static void expect_whole(const Json& answer) {
    EXPECT_TRUE(answer.value("ok", false)) << answer.dump();
    EXPECT_EQ(answer.value("board", ""), "whole") << answer.dump();
    EXPECT_TRUE(answer["to_finish"].is_null());
  }

 private:
  std::optional<BegunParts> parts_;
  int id_ = 100;
};

TEST_F(APartThatIsCut, is_refused_and_made_whole_by_what_was_cut) {
  cut();
  const int stood = moved_at_;
  expect_refused(run(), {"the part in the machine was begun at 20", "1 of its 3 features", "--only corner",
                         "`gantry part-removed`"});
  EXPECT_EQ(moved_at_, stood) << "nothing has moved";
  EXPECT_EQ(code_of(run({{"only", {"cornr"}}})), "G901");
  EXPECT_EQ(code_of(run({{"only", "corner"}})), "G702") << "no list: not taken for all features";
  EXPECT_EQ(code_of(run({{"from", 3}})), "G702");
  expect_whole(run({{"only", {"corner"}}}));
  EXPECT_EQ(remembered(), 0u);
  expect_whole(run());
}

TEST_F(APartThatIsCut, stays_begun_when_only_something_else_is_dispensed) {
  cut();
  const Json again = run({{"only", {"b"}}});
  EXPECT_TRUE(again.value("ok", false)) << "what was asked for is done: " << again.dump();
  EXPECT_EQ(again.value("board", ""), "begun");
  EXPECT_EQ(again.value("to_finish", ""), "--only corner");
  EXPECT_TRUE(clamped()) << "it lacks something: nobody has asked for it";
  expect_refused(run({{"serial", "Z1"}}), {"the part in the machine", "say `gantry part-removed` when"});
  expect_whole(run({{"only", {"corner"}}}));
  EXPECT_FALSE(clamped());
}

TEST_F(APartThatIsCut, is_another_one_when_it_was_taken_out) {
  cut();
  const Json out = ask({{"order", "part_removed"}});
  EXPECT_TRUE(out.value("ok", false)) << out.dump();
  EXPECT_NE(out.value("said", "").find("is not waited for any more"), std::string::npos) << out.dump();
  EXPECT_EQ(remembered(), 0u);
  const Json unknown = ask({{"order", "part_removed"}, {"serial", "S-7"}});
  EXPECT_NE(unknown.value("said", "").find("no part with serial 'S-7' was begun"), std::string::npos) << unknown.dump();
  expect_whole(run());
}

TEST_F(APartThatIsCut, is_known_by_its_serial_wherever_it_has_been) {
  cut({{"serial", "S/1"}});
  expect_refused(run({{"serial", "S/1"}}),
                 {"the part with serial 'S/1'", "--only corner", "part-removed --serial S/1"});
  expect_refused(run(), {"the part with serial 'S/1'"});  // the clamp has not opened: it is in the machine
  expect_whole(run({{"serial", "S/2"}}));
  expect_whole(run());  // the clamp has opened, and nobody says what lies there
  expect_refused(run({{"serial", "S/1"}}), {"1 of its 3 features"});
  std::string text;
  {
    std::ifstream file(kShort);
    text.assign(std::istreambuf_iterator<char>(file), {});
  }
  std::ofstream(folder_ / "short-board.yaml") << text + "\n# changed\n";
  expect_refused(run({{"serial", "S/1"}, {"only", {"corner"}}}, folder_ / "short-board.yaml"),
                 {"this recipe as it was before it was changed"});
  expect_whole(run({{"serial", "S/1"}, {"only", {"corner"}}}));
  expect_whole(run({{"serial", "S/1"}}));
}

TEST_F(APartThatIsCut, is_remembered_before_its_first_shot_and_a_lost_one_asks_for_eyes) {
  bool seen_before_valve = false, valve = false;
  std::filesystem::path copy = folder_ / "lost";
  on_cycle_ = [&] {
    if (valve || (owner_->latest().outputs & config::bit(config::Output::Valve)) == 0) return;
    valve = true;
    seen_before_valve = remembered() == 1;
    std::filesystem::copy(kept(), copy);  // what a disk holds when the power fails here
  };
  cut();
  EXPECT_TRUE(valve);
  EXPECT_TRUE(seen_before_valve);
  EXPECT_EQ(began_in(kept()), began_in(copy)) << "when its job began, not when it ended";
  std::filesystem::remove_all(kept());
  std::filesystem::copy(copy, kept());
  for (const char* clamp : {"closed", "open, as after a power cut"}) {
    expect_refused(run(), {"nobody saw how far it came", "--from FEATURE or --only FEATURES"});
    ASSERT_TRUE(owner_->part_removed()) << clamp;  // not by an order: nobody says that it is out
  }
  const Json rest = run({{"from", "b"}});
  EXPECT_TRUE(rest.value("ok", false)) << rest.dump();
  EXPECT_EQ(rest.value("board", ""), "begun") << "nobody has seen 'a'";
  EXPECT_EQ(rest.value("to_finish", ""), "--only a");
}

/// While the part is written down the machine is served: an abort that comes then is none that meets a job.
TEST_F(APartThatIsCut, is_not_begun_by_a_job_that_is_aborted_while_it_is_written_down) {
  bool sent = false;
  on_cycle_ = [&] {
    if (!sent && remembered() > 0) sent = client_->say("{\"order\":\"abort\",\"id\":2}\n") > 0;
  };
  const int stood = moved_at_;
  const Json answer = run();
  EXPECT_TRUE(sent);
  EXPECT_EQ(code_of(answer), "G701") << answer.dump();
  EXPECT_EQ(answer.value("board", ""), "untouched");
  EXPECT_EQ(moved_at_, stood);
  EXPECT_EQ(remembered(), 0u);
}

/// The clamp opens when a job ends `done` and by `part_removed`: until then nobody dispenses over a finished part.
class APartWithDefects : public APartThatIsCut {
 protected:
  [[nodiscard]] std::string script() const override { return ""; }
  void SetUp() override {
    APartThatIsCut::SetUp();
    on_cycle_ = [this] {
      if (!slowed_ && (owner_->latest().outputs & config::bit(config::Output::Valve)) != 0)
        slowed_ = client_->say("{\"order\":\"override\",\"value\":0.2}\n") > 0;
    };
    first_ = run();
    ASSERT_EQ(first_.value("result", ""), "done_with_defects") << first_.dump();
    EXPECT_TRUE(ask({{"order", "override"}, {"value", 1}}).value("ok", false));
  }
  Json first_;

 private:
  bool slowed_ = false;
};

TEST_F(APartWithDefects, stays_clamped_and_no_job_begins_over_it_until_it_is_removed) {
  EXPECT_TRUE(clamped());
  EXPECT_NE(first_.value("said", "").find("`gantry part-removed` opens it"), std::string::npos) << first_.dump();
  const int stood = moved_at_;
  const Json refused = run();
  EXPECT_EQ(code_of(refused), "G702") << refused.dump();
  EXPECT_NE(refused.dump().find("say `gantry part-removed` to open the clamp"), std::string::npos) << refused.dump();
  EXPECT_EQ(refused.value("board", ""), "defects");
  EXPECT_EQ(moved_at_, stood);
  EXPECT_TRUE(ask({{"order", "part_removed"}}).value("ok", false));
  EXPECT_FALSE(clamped());
  expect_whole(run());
}

TEST_F(APartWithDefects, may_get_a_feature_once_more) {
  const Json again = run({{"only", {"b"}}});
  EXPECT_NE(code_of(again), "G702") << again.dump();
  EXPECT_EQ(again.value("board", ""), "defects") << again.dump();
  EXPECT_TRUE(again["to_finish"].is_null()) << again.dump();
}

TEST_F(APartWithDefects, is_another_one_than_that_of_a_serial_only_when_both_have_serials) {
  EXPECT_EQ(code_of(run({{"serial", "S/1"}})), "G702");
  EXPECT_TRUE(ask({{"order", "part_removed"}, {"serial", "S/1"}}).value("ok", false));
  expect_whole(run({{"serial", "S/1"}}));
}

TEST_F(APartThatIsCut, whose_file_cannot_be_read_is_not_run_over) {
  cut();
  std::ofstream(kept() / "part.json") << "{\"format\": 1, \"left\": [[5, 99999999999]]}";
  const Json answer = run();
  EXPECT_EQ(code_of(answer), "G405") << answer.dump();
  EXPECT_NE(answer.dump().find("part.json"), std::string::npos);
}

class AStartButton : public Desks {
  std::string script() const override {
    return "- {at: cycle 3000, do: press, input: start}\n"
           "- {at: cycle 60000, do: set_input, input: mode, on: false}\n"
           "- {at: cycle 61000, do: press, input: start}";
  }
};

TEST_F(AStartButton, runs_the_recipe_of_the_desk_and_in_setup_nothing) {
  std::size_t done = 0;
  std::string mode;
  std::filesystem::current_path(folder_);  // results go to out/ where the owner stands
  bool asked = false, moved_in_setup = false;
  on_cycle_ = [&] {
    const auto& s = owner_->latest();
    done = std::max(done, owner_->progress().features_done);
    if (s.cycle > 60'100 && owner_->in_setup() && s.state == cycle::State::Running) moved_in_setup = true;
    if (asked || s.cycle <= 63'000) return;
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
  EXPECT_EQ(result_of("short-board-002"), "failed");
}

}  // namespace
}  // namespace gantry::desk
