// A recipe is loaded, compiled and proved for a verb, which shows on a terminal how long that takes, and ends when it
// is asked to (app/cli/signals.hpp).
//   const auto prepared = prepare_heard("checking " + file, context, [&](const Heard& heard) {
//     return desk::prepare(machine, file, {}, {.breath = heard.breath, .progress = heard.progress});
//   });
#pragma once
#include <functional>
#include <string>

#include "app/cli/verbs.hpp"
#include "app/desk/prepare.hpp"
#include "core/breath.hpp"
#include "core/progress.hpp"

namespace gantry::cli {

struct Heard {
  Breath breath{};  ///< no more when the verb was asked to end
  Progress progress{};
};

/// `prepare` runs on another thread. A proof that was given up fails with Fault::Interrupted. What does not look at its
/// breath for 0.2 s after the verb was asked to end, such as the reading of a large file, ends with the program: exit
/// code 130; nothing has moved, and nothing was written.
Checked<desk::Prepared> prepare_heard(const std::string& what, const Context& context,
                                      const std::function<Checked<desk::Prepared>(const Heard&)>& prepare);

}  // namespace gantry::cli
