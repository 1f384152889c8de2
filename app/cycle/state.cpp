#include "app/cycle/channels.hpp"

namespace gantry::cycle {

const char* name(State state) noexcept {
  switch (state) {
    case State::Offline: return "offline";
    case State::Disabled: return "disabled";
    case State::Enabling: return "enabling";
    case State::Ready: return "ready";
    case State::Homing: return "homing";
    case State::Running: return "running";
    case State::Held: return "held";
    case State::Stopping: return "stopping";
    case State::Stopped: return "stopped";
  }
  return "?";
}

}  // namespace gantry::cycle
