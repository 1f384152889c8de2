#include "app/cli/keys.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string>
#include <unistd.h>

#include "app/cli/verbs.hpp"
#include "core/log.hpp"

namespace gantry::cli {
namespace {

constexpr int kBarWidth = 24;
constexpr std::int64_t kShowEvery = 100;  // cycles

}  // namespace

Keys::Keys(Operated& machine, bool progress) : machine_(machine) {
  progress_ = progress && isatty(STDERR_FILENO) != 0;
  keys_ = progress && isatty(STDIN_FILENO) != 0 && tcgetattr(STDIN_FILENO, &saved_) == 0;
  if (!keys_) return;
  termios raw = saved_;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  fmt::print(stderr, "keys: space hold and resume, a abort, + and - override, Ctrl-C ends\n");
}

void Keys::end() {
  if (keys_) tcsetattr(STDIN_FILENO, TCSANOW, &saved_);
  keys_ = false;
  if (shown_) fmt::print(stderr, "\r\x1b[K");
  shown_ = progress_ = false;
}

void Keys::poll() {
  if (interrupted() && !interrupted_) {
    interrupted_ = true;
    machine_.interrupt();
  }
  char key = 0;
  while (keys_ && read(STDIN_FILENO, &key, 1) == 1) press(key);
  if (const auto reset = machine_.reset_answer(); reset && !*reset) log::report(reset->error());
  if (progress_) show_progress();
}

void Keys::press(char key) {
  using run::OrderKind;
  run::Order order;
  switch (key) {
    case ' ': order.kind = machine_.seen().held ? OrderKind::Resume : OrderKind::Hold; break;
    case 'a': order.kind = OrderKind::Abort; break;
    case 'r': order.kind = OrderKind::Reset; break;
    case '+':
    case '-':
      order.kind = OrderKind::Override;
      override_ = std::clamp(override_ + (key == '+' ? 0.1 : -0.1), 0.1, 2.0);
      order.value = override_;
      break;
    default: return;
  }
  if (auto done = machine_.order(order); !done) log::report(done.error());
}

void Keys::show_progress() {
  const JobSeen s = machine_.seen();
  if (s.cycle - last_shown_ < kShowEvery) return;
  last_shown_ = s.cycle;
  const run::Progress& p = s.progress;
  const int filled = p.features_total == 0 ? 0 : static_cast<int>(kBarWidth * p.features_done / p.features_total);
  fmt::print(stderr, "\r\x1b[K[{}{}] {}/{} {} {:.0f} s{} {}{}", std::string(static_cast<std::size_t>(filled), '#'),
             std::string(static_cast<std::size_t>(kBarWidth - filled), '.'), p.features_done, p.features_total, p.doing,
             p.elapsed_s, s.remaining_s ? fmt::format(", about {:.0f} s left,", *s.remaining_s) : "", s.state,
             s.override_factor == 1 ? "" : fmt::format(" {:.0f} %", s.override_factor * 100));
  shown_ = true;
}

}  // namespace gantry::cli
