// A desk over a whole machine in virtual time; clients speak through the socket, and their clock is the test's.
//   class ADoorThatOpens : public Desks { std::string script() const override { return "..."; } };
#pragma once
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <unistd.h>

#include "app/desk/answer.hpp"
#include "app/desk/desk.hpp"
#include "tests/app/desk/peer.hpp"

namespace gantry::desk {

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
    change(machine_);
    run::OwnerOptions options;
    options.virtual_time = true;
    if (!script().empty()) {
      std::ofstream(folder_ / "script.yaml") << script();
      options.sim.script_file = folder_ / "script.yaml";
    }
    auto owner = run::Owner::open(machine_, options);
    ASSERT_TRUE(owner) << to_text(owner.error());
    owner_ = std::move(*owner);
    door_ = std::move(*OrderSocket::listen(folder_ / "owner.sock"));
    make_desk();
    owner_->on_step([this] { step(); });
    const auto up = desk_->bring_up();
    ASSERT_TRUE(up) << to_text(up.error());
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
  /// Made to the machine file's content.
  virtual void change(config::Machine& /*machine*/) const {}
  /// Where parts are remembered; null: nowhere.
  [[nodiscard]] virtual BegunParts* parts() { return nullptr; }
  void make_desk() {
    desk_ = std::make_unique<Desk>(
        machine_, *owner_, *door_, clock_,
        Desk::Options{.interrupted = [] { return false; }, .recipe = source_ / kShort, .parts = parts()});
  }
  /// Each cycle lasts as long for the clients too.
  void step() {
    clock_.sleep_until(clock_.now() + machine_.bus.cycle);
    ++steps_;
    if (client_) heard_ += client_->hear();
    if (on_cycle_) on_cycle_();
    desk_->poll();
    const double x = owner_->latest().target[0];
    if (x != last_x_) moved_at_ = steps_;
    last_x_ = x;
  }
  /// The line that asks for a job, whose files go to a folder of this name.
  [[nodiscard]] std::string run_order(int id, const std::string& out = "job",
                                      const std::string& recipe = kShort) const {
    return "{\"order\":\"run\",\"id\":" + std::to_string(id) + ",\"recipe\":\"" +
           std::filesystem::absolute(recipe).string() + "\",\"out\":\"" + (folder_ / out).string() + "\"}\n";
  }
  /// The answer with this id, if it has come. Lines before `from` are not looked at again.
  [[nodiscard]] Json answer(int id, std::size_t& from) const {
    if (from > heard_.size()) from = 0;  // a test has emptied it
    for (std::size_t end; (end = heard_.find('\n', from)) != std::string::npos; from = end + 1) {
      Json line = Json::parse(heard_.begin() + static_cast<std::ptrdiff_t>(from),
                              heard_.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
      if (line.is_object() && line.value("id", 0) == id) return line;
    }
    return {};
  }
  [[nodiscard]] Json answer(int id) const {
    std::size_t from = 0;
    return answer(id, from);
  }
  [[nodiscard]] bool answered(int id) const { return !answer(id).is_null(); }
  /// Serves until `id` is answered, and `cycles` more.
  void serve_until(int id, int cycles = 0) {
    const auto asked = on_cycle_;
    int left = 200'000, more = cycles;
    std::size_t looked_at = 0;
    on_cycle_ = [&, asked] {
      if (asked) asked();
      if (answer(id, looked_at).is_null() && --left > 0) return;
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

inline std::string code_of(const Json& answer) {
  const auto errors = errors_of(answer);
  return errors.empty() ? "" : std::string(std::string_view(code(errors.front().fault)));
}

}  // namespace gantry::desk
