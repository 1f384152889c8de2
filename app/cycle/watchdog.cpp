#include "app/cycle/watchdog.hpp"

#include <sys/socket.h>

namespace gantry::cycle {
namespace {

constexpr Time kLook = milliseconds(1);  // while there is no beat to count from

}  // namespace

bool send(StopFrame& stop) noexcept {
  const auto frames = stop.take_over();
  bool all = !frames.empty();
  for (const devices::FrameBytes& frame : frames) {
    const ssize_t sent = ::send(stop.socket(), frame.bytes.data(), frame.size, MSG_DONTWAIT | MSG_NOSIGNAL);
    all = all && sent == static_cast<ssize_t>(frame.size);
  }
  return all;
}

Watchdog::Watchdog(StopFrame& stop, Clock& clock, Time stuck_after)
    : stop_(stop), clock_(clock), stuck_after_(stuck_after) {
  running_ = start_thread(thread_, "gantry-watchdog", kWatchdogPriority, &Watchdog::run, this, rights_);
}

Watchdog::~Watchdog() {
  if (!running_) return;
  quit_.store(true);
  pthread_join(thread_, nullptr);
}

void* Watchdog::run(void* self) {
  static_cast<Watchdog*>(self)->watch();
  return nullptr;
}

void Watchdog::watch() noexcept {
  Time spoken_for{};  // the beat after which it has spoken
  while (!quit_.load()) {
    const Time beat = stop_.last_beat();
    if (beat == spoken_for) {
      clock_.sleep_until(clock_.now() + kLook);
      continue;
    }
    clock_.sleep_until(beat + stuck_after_);
    if (quit_.load() || stop_.last_beat() != beat) continue;
    spoken_for = beat;
    send(stop_);
    strikes_.fetch_add(1);
  }
}

}  // namespace gantry::cycle
