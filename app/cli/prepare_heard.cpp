#include "app/cli/prepare_heard.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <optional>

#include "app/cli/long_work.hpp"
#include "app/cli/signals.hpp"

namespace gantry::cli {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kLookEvery{5}, kGiveUp{200};

const Error kAskedToEnd{Fault::Interrupted, "interrupted while the recipe was prepared; nothing has moved", ""};

}  // namespace

Checked<desk::Prepared> prepare_heard(const std::string& what, const Context& context,
                                      const std::function<Checked<desk::Prepared>(const Heard&)>& prepare) {
  LongWork work(what);
  const Heard heard{.breath = [breath = work.breath()] { return breath() && !interrupted(); },
                    .progress = work.progress()};
  auto prepared = std::async(std::launch::async, [&] { return prepare(heard); });
  for (std::optional<Clock::time_point> asked; prepared.wait_for(kLookEvery) != std::future_status::ready;) {
    if (!asked && interrupted()) asked = Clock::now();
    if (!asked || Clock::now() - *asked < kGiveUp) continue;
    const int exit_code = show(kAskedToEnd, context.json, context.board);
    static_cast<void>(std::fflush(nullptr));
    std::_Exit(exit_code);  // the other thread still reads what stands on this one's stack
  }
  auto done = prepared.get();
  if (done && !done->proof && done->proof.error().fault == Fault::Aborted && interrupted())
    done->proof = tl::unexpected(kAskedToEnd);
  return done;
}

}  // namespace gantry::cli
