// The last word on the bus: a frame (several, where the map needs them) that stops every drive and puts every output
// off but the clamp's, for whoever finds that the loop cannot speak any more (watchdog.hpp, crash_stop.hpp). The loop
// makes it anew in every cycle from the image that it is about to send, so that modes, targets and all else in it are
// as last commanded; sending it is one send() of bytes that stand ready. A drive whose quick stop is known to brake is
// put into quick stop. Any other one would perhaps only lose its torque: it is told to halt and to stand at its last
// target, until its station's watchdog takes the torque (decision 14).
//   StopFrame stop(setup, port.descriptor());
//   stop.make(bus, standing); stop.begin_exchange(now); ... stop.end_exchange(); if (stop.take_sent()) ...  // the loop
//   if (now - stop.last_beat() > limit) send(stop);                                               // anybody
// The loop's side is RT. Everybody else may read at any time, also in a signal handler.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "app/cycle/loop_setup.hpp"
#include "core/clock.hpp"
#include "core/rt/fixed_vector.hpp"
#include "devices/bus.hpp"

namespace gantry::cycle {

class StopFrame {
 public:
  /// `socket`: FramePort::descriptor(). Nobody sends before the loop has made the first frame.
  StopFrame(const LoopSetup& setup, int socket) noexcept;

  // --- the loop ------------------------------------------------------------------------------------------------------
  /// The bus's image holds what is to be sent in this cycle; it stays as it is. `standing`: bit d for a drive that has
  /// torque and is to stand at its target; all others are put into quick stop.
  void make(devices::FieldBus& bus, std::uint32_t standing = 0) noexcept;
  /// Of the drives, as the last make() was told.
  [[nodiscard]] std::uint32_t standing() const noexcept { return standing_; }
  /// Turns the bus's own image into a stop.
  void write_into(devices::FieldBus& bus) const noexcept;
  /// A sign of life; then the frame of the cycle goes out, and what comes back is taken.
  void begin_exchange(Time now) noexcept {
    last_beat_.store(now.count());
    exchanging_.store(true);
  }
  void end_exchange() noexcept { exchanging_.store(false); }
  /// Somebody has spoken for the loop. What it was about to send must not follow.
  [[nodiscard]] bool sent() const noexcept { return sent_.load(); }
  /// The same; true once.
  [[nodiscard]] bool take_sent() noexcept { return sent_.exchange(false); }

  // --- anybody -------------------------------------------------------------------------------------------------------
  [[nodiscard]] Time last_beat() const noexcept { return Time{last_beat_.load()}; }  ///< 0: none yet
  /// The loop may be handing its own frame to the system: that frame may still come after ours.
  [[nodiscard]] bool exchanging() const noexcept { return exchanging_.load(); }
  [[nodiscard]] int socket() const noexcept { return socket_; }
  /// Tells the loop that it is spoken for, and gives the frames; none when there are none yet. While they are being
  /// sent the loop may run on and make them anew, which changes nothing but targets of axes that are to stop.
  [[nodiscard]] std::span<const devices::FrameBytes> take_over() noexcept {
    sent_.store(true);
    const int ready = ready_.load();
    if (ready < 0) return {};
    const Buffer& b = buffers_[static_cast<std::size_t>(ready)];
    return std::span(b.frames).first(b.count);
  }

 private:
  struct Buffer {
    std::array<devices::FrameBytes, devices::kMaxCyclicFrames> frames;
    std::size_t count = 0;
  };
  /// Both bytes of a controlword.
  struct Word {
    std::uint32_t drive = 0;  ///< its bit
    std::size_t at = 0;       ///< of the low byte's change
  };
  rt::FixedVector<devices::ImageChange, 2 * kMaxDrives + 32> changes_;
  rt::FixedVector<Word, kMaxDrives> words_;
  std::uint32_t standing_ = 0;
  int socket_;
  std::array<Buffer, 2> buffers_;
  // All in one order for everybody: either the loop sees that it is spoken for, or its exchange is seen.
  std::atomic<int> ready_{-1};  ///< index of the buffer that nobody writes
  std::atomic<std::int64_t> last_beat_{0};
  std::atomic<bool> exchanging_{false}, sent_{false};
};

}  // namespace gantry::cycle
