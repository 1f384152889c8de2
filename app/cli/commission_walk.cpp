#include "app/cli/commission_walk.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include "app/cli/client.hpp"
#include "app/cli/operated.hpp"
#include "app/cli/signals.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/today.hpp"
#include "app/desk/state_folder.hpp"
#include "app/job/walk.hpp"
#include "app/run/walk.hpp"

namespace gantry::cli {
namespace {

constexpr const char* kSetup = "[{do: set_input, input: mode, on: false}]";

/// Ctrl-C, and Ctrl-Z as well: a loop that stops with its process would leave torque without its master.
bool ended() {
  static bool wished = false;
  wished = wished || take_hold_wish();
  return wished || interrupted();
}

/// Lines of stdin as they come; a terminal that is gone, Ctrl-C and Ctrl-Z end it.
class Lines {
 public:
  explicit Lines(bool patient) : patience_ms_(patient ? 20 : 0) {}

  Result<std::optional<std::string>> next() {
    if (ended()) return fail(Fault::Interrupted, "interrupted; nothing is kept of the walk");
    if (const auto end = read_.find('\n'); end != std::string::npos) {
      std::string line = read_.substr(0, end);
      read_.erase(0, end + 1);
      return line;
    }
    pollfd in{STDIN_FILENO, POLLIN, 0};
    if (::poll(&in, 1, patience_ms_) <= 0) return std::nullopt;
    char bytes[256];
    const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (got <= 0 && !read_.empty()) return std::exchange(read_, {});  // the last line of a file without its end
    if (got <= 0) return fail(Fault::Aborted, "the answers have ended before the walk; nothing is kept of it");
    read_.append(bytes, static_cast<std::size_t>(got));
    return std::nullopt;
  }

  /// What a person has typed before the question: a key that bounced is no consent. Answers from a file stay.
  void forget() {
    if (::isatty(STDIN_FILENO) == 0) return;
    read_.clear();
    ::tcflush(STDIN_FILENO, TCIFLUSH);
  }

 private:
  int patience_ms_;  ///< in virtual time, which would run on while a person looks
  std::string read_;
};

Result<std::vector<const config::Axis*>> walk_all(const config::Machine& machine, const run::OwnerOptions& own,
                                                  const std::string& date) {
  hold_machine(Terminal::Matters);
  hold_on_stop_key();
  auto owner = run::Owner::open(machine, own);
  if (!owner) return tl::unexpected(owner.error());
  OwnerOperated operated(**owner);
  bool asked = false;
  const auto poll = [&] {
    if (ended() && !std::exchange(asked, true)) operated.interrupt();
  };
  (*owner)->on_step(poll);
  Lines lines(own.virtual_time);
  Result<void> ready = (*owner)->bring_up();
  if (ready && own.virtual_time && machine.inputs[static_cast<std::size_t>(config::Input::Mode)]) {
    ready = (*owner)->world()->add_script(kSetup);
    say("the mode switch of the simulated machine is turned to setup\n");
    for (int i = 0; ready && i < 20; ++i) ready = (*owner)->idle();
  }
  const run::WalkTalk talk{.say = [](const std::string& words) { say_text(words); },
                           .hear = [&] { return lines.next(); },
                           .poll = poll,
                           .forget = [&] { lines.forget(); }};
  auto walked = ready ? run::walk(**owner, machine, talk)
                      : Result<std::vector<const config::Axis*>>(tl::unexpected(ready.error()));
  if (walked)
    if (auto kept = (*owner)->keep_walk(date); !kept) walked = tl::unexpected(kept.error());
  (*owner)->shut_down();
  return walked;
}

}  // namespace

void commission_walk(Context& context, config::Machine machine, const std::string& interface,
                     const std::string& state) {
  const auto stop_with = [&](const Error& error) { context.exit_code = show(error, context.json); };
  const auto folder = state_of(context, state);
  if (!folder) return;
  if (auto made = desk::open_state_folder(*folder); !made) return stop_with(made.error());
  run::OwnerOptions own;
  own.bus = interface.empty() ? "sim" : "ethercat:" + interface;
  own.virtual_time = interface.empty();
  own.state = *folder;
  own.interrupted = interrupted;
  const std::string date = today();
  const auto walked = walk_all(machine, own, date);
  if (!walked) return stop_with(walked.error());
  nlohmann::ordered_json names = nlohmann::ordered_json::array();
  std::string words;
  for (const config::Axis* axis : *walked) {
    names.push_back(axis->name);
    words += (words.empty() ? "" : ", ") + axis->name;
  }
  if (context.json)
    show_document("done", {{"axes", names}, {"date", date}});
  else
    print_text("walked {}: {} move as the machine file says\n", date, words);
}

}  // namespace gantry::cli
