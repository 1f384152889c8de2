#include "app/cli/long_work.hpp"

#include <cmath>
#include <fmt/format.h>
#include <unistd.h>

#include "app/cli/terminal.hpp"
#include "core/clean_text.hpp"
#include "core/log.hpp"
#include "core/status_line.hpp"

namespace gantry::cli {
namespace {

// And what is done sooner shows nothing.
constexpr std::chrono::milliseconds kRepeatEvery{200}, kLineEvery{10000};

}  // namespace

LongWork::LongWork(std::string what) : what_(std::move(what)), terminal_(writes_over(STDERR_FILENO)) {}

LongWork::~LongWork() {
  if (terminal_ && in_front(STDERR_FILENO)) clear_status();
}

Breath LongWork::breath() {
  return [this] {
    show();
    return true;
  };
}

Progress LongWork::progress() {
  return [this](std::size_t done, std::size_t total) {
    done_ = done, total_ = total;
    show();
  };
}

void LongWork::show() {
  const auto now = Clock::now();
  if (now - shown_ < (terminal_ ? kRepeatEvery : kLineEvery) || (terminal_ && !in_front(STDERR_FILENO))) return;
  shown_ = now;
  const double gone_s = std::chrono::duration<double>(now - begin_).count();
  const auto done = static_cast<double>(done_), total = static_cast<double>(total_);
  const std::string left = done_ == 0 ? ""
                                      : fmt::format(", {:.0f} %, about {:.0f} s left", std::floor(100 * done / total),
                                                    gone_s * (total - done) / done);
  const std::string text = fmt::format("{}: {:.1f} s{}", clean_text(what_), gone_s, left);
  if (terminal_)
    show_status(text);
  else
    log::info("{}", text);
}

}  // namespace gantry::cli
