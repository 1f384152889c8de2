// `gantry publish`: the one process that speaks DDS for the machine. The owner starts it as a child (child.hpp) and
// shares memory with it; whatever becomes of it, the owner does not notice.
//   give_up_rights();
//   publish(3, {}, stop);     // returns when the owner has gone, or `stop` is set
#pragma once
#include <atomic>

#include "app/monitor/dds.hpp"
#include "core/error.hpp"

namespace gantry::monitor {

struct PublishOptions {
  NetworkOptions network;
  double rate_hz = 50;          ///< of the state; it is also sent when something else than a position changes
  double owner_silent_s = 5.0;  ///< after that the owner counts as dead
};

/// shm_fd: the owner's memory, closed when it is mapped. The owner's end, by process number, by its own word or by its
/// silence, is the normal way to return. Fault::DdsUnusable, Fault::Usage, and those of SnapshotReader::open.
Result<void> publish(int shm_fd, const PublishOptions& options, const std::atomic<bool>& stop);

}  // namespace gantry::monitor
