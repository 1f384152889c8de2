#include "app/cli/keys.hpp"

#include <algorithm>
#include <string>
#include <unistd.h>

#include "app/cli/signals.hpp"
#include "core/log.hpp"
#include "core/status_line.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::cli {
namespace {

constexpr int kWidestBar = 24, kNarrowestBar = 4, kShareOfLine = 5;
constexpr std::chrono::milliseconds kShowEvery{100};

/// In steps of 10 %, up to 10 % of 1 %.
double next_override(double factor, bool more) {
  constexpr double kCoarse = 0.1, kFine = 0.01, kRounding = 1e-6;
  const bool fine = more ? factor < kCoarse - kRounding : factor < kCoarse + kRounding;
  const double step = fine ? kFine : kCoarse;
  return std::clamp(factor + (more ? step : -step), motion::kLeastOverride, motion::kMostOverride);
}

}  // namespace

Keys::Keys(Operated& machine, Shows shows, bool heeds_shell) : machine_(machine) {
  if (heeds_shell) shell_.emplace(machine);
  progress_ = shows != Shows::Nothing && writes_over(STDERR_FILENO);
  virtual_time_ = shows == Shows::Progress;
  keys_ = usable(shows == Shows::ProgressAndKeys);
  if (!keys_) return;
  raw_ = terminal_.enter();
  if (raw_)
    say("keys: space hold and resume, n hold now, a abort, r reset, + and - override, Ctrl-Z holds and suspends, "
        "Ctrl-C ends\n");
}

bool Keys::usable(bool progress) { return progress && isatty(STDIN_FILENO) != 0; }

void Keys::clear_line() {
  if (in_front(STDERR_FILENO)) clear_status();
}

void Keys::end() {
  terminal_.leave();
  clear_line();
  keys_ = raw_ = progress_ = false;
}

void Keys::sleep() {
  clear_line();
  terminal_.leave();
  raw_ = false;
  asleep_ = true;
}

void Keys::poll() {
  if (keys_ && !interrupted_) read_keys();
  if (interrupted() && !interrupted_) {
    interrupted_ = true;
    machine_.interrupt();
  }
  if (const auto reset = machine_.reset_answer(); reset && !*reset) log::report(reset->error());
  if (shell_) shell_->poll([this] { sleep(); });
  if (take_continued()) asleep_ = raw_ = false;  // a shell sets its own mode while it has the terminal
  if (progress_ && !asleep_) show_progress();
}

void Keys::read_keys() {
  const bool ours = !asleep_ && in_front(STDIN_FILENO);
  if (ours && !raw_) terminal_.enter();
  raw_ = ours;
  while (const auto key = raw_ ? read_key() : std::nullopt) press(*key);
}

void Keys::press(char key) {
  using run::OrderKind;
  run::Order order;
  switch (key) {
    case ' ': order.kind = machine_.seen().held ? OrderKind::Resume : OrderKind::Hold; break;
    case 'n':
      order.kind = OrderKind::Hold;
      order.now = true;
      break;
    case 'a': order.kind = OrderKind::Abort; break;
    case 'r': order.kind = OrderKind::Reset; break;
    case '+':
    case '-':
      order.kind = OrderKind::Override;
      order.value = next_override(machine_.seen().override_factor, key == '+');
      break;
    default: return;
  }
  if (auto done = machine_.order(order); !done) log::report(done.error());
}

void Keys::show_progress() {
  const JobSeen s = machine_.seen();
  const auto now = Clock::now();
  if (now - last_shown_ < kShowEvery || !in_front(STDERR_FILENO)) return;
  last_shown_ = now;
  const run::Progress& p = s.progress;
  const auto width =
      static_cast<std::size_t>(std::clamp(columns_of(STDERR_FILENO) / kShareOfLine, kNarrowestBar, kWidestBar));
  const std::size_t filled = p.features_total == 0 ? 0 : width * p.features_done / p.features_total;
  const bool names_it = p.feature.empty() || p.doing.find(p.feature) != std::string::npos;
  const std::string doing = names_it ? p.doing : fmt::format("{} '{}'", p.doing, p.feature);
  // Between two blocks the loop is ready, but the machine is not free.
  const bool between = p.features_total > 0 && s.state == cycle::name(cycle::State::Ready);
  std::optional<double> left_s = p.remaining_s;
  if (left_s && virtual_time_) {
    const double waited_s = std::chrono::duration<double>(now - begin_).count();
    left_s = p.elapsed_s > 0 ? std::optional(waited_s * *left_s / p.elapsed_s) : std::nullopt;
  }
  // What a narrow terminal cuts off is what it is doing.
  show_status(fmt::format("[{}{}] {}/{} {:.0f} s{} {}{} {}", std::string(filled, '#'), std::string(width - filled, '.'),
                          p.features_done, p.features_total, p.elapsed_s,
                          left_s ? fmt::format(", about {:.0f} s left,", *left_s) : "",
                          between ? std::string(cycle::name(cycle::State::Running)) : s.state,
                          s.override_factor == 1 ? "" : fmt::format(" {:.0f} %", s.override_factor * 100), doing));
}

}  // namespace gantry::cli
