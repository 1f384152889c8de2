#include "app/cli/long_work.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "app/cli/terminal.hpp"
#include "core/clean_text.hpp"
#include "core/status_line.hpp"

namespace gantry::cli {
namespace {

constexpr std::chrono::milliseconds kRepeatEvery{200};  // and what is done sooner shows nothing

}  // namespace

LongWork::LongWork(std::string what) : what_(std::move(what)), shows_(isatty(STDERR_FILENO) != 0) {}

LongWork::~LongWork() {
  if (shows_ && in_front(STDERR_FILENO)) clear_status();
}

Breath LongWork::breath() {
  return [this] {
    if (shows_) show();
    return true;
  };
}

void LongWork::show() {
  const auto now = Clock::now();
  if (now - shown_ < kRepeatEvery || !in_front(STDERR_FILENO)) return;
  shown_ = now;
  show_status(fmt::format("{}: {:.1f} s", clean_text(what_), std::chrono::duration<double>(now - begin_).count()));
}

}  // namespace gantry::cli
