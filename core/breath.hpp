// Long work that can be given up: it calls its breath between pieces, and stops when that says no.
//   if (!go_on(breath)) return given_up();
// On a worker thread the breath looks at a flag; in virtual time it lets orders in. It is called often (at least once a
// feature in planning), so it should cost little.
#pragma once
#include <functional>

#include "core/error.hpp"

namespace gantry {

/// False: give up. Empty: the work is never given up.
using Breath = std::function<bool()>;

inline bool go_on(const Breath& breath) { return !breath || breath(); }

inline tl::unexpected<Error> given_up() {
  return fail(Fault::Aborted, "given up before it was done; nothing has changed by it");
}

}  // namespace gantry
