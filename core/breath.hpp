// Long work that can be given up: it calls its breath between pieces, and stops when that says no.
//   if (!go_on(breath)) return given_up();
// On a worker thread the breath looks at a flag; in virtual time it lets orders in. It is called often (at least once a
// feature in planning), so it should cost little.
#pragma once
#include <cstddef>
#include <functional>

#include "core/error.hpp"

namespace gantry {

/// False: give up. Empty: the work is never given up.
using Breath = std::function<bool()>;

inline bool go_on(const Breath& breath) { return !breath || breath(); }

/// Of a pass over much that is quick for each and is not given up: lets others in now and then.
///   Pauses pause(breath, 256);   for (const Segment& s : segments) pause(), look_at(s);
class Pauses {
 public:
  Pauses(const Breath& breath, std::size_t every) : breath_(breath), every_(every) {}
  void operator()() {
    if (++n_ % every_ == 0) static_cast<void>(go_on(breath_));
  }

 private:
  const Breath& breath_;
  std::size_t every_, n_ = 0;
};

inline tl::unexpected<Error> given_up() {
  return fail(Fault::Aborted, "given up before it was done; nothing has changed by it");
}

}  // namespace gantry
