#include "core/rt/trap.hpp"

namespace gantry::rt {

constinit thread_local int rt_depth = 0;

}  // namespace gantry::rt
