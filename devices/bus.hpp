// A fieldbus as the machine uses it. Bring-up and object access block and belong to the run thread; the process image
// and exchange() belong to the loop.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "config/drive.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "core/id.hpp"
#include "devices/frame_bytes.hpp"
#include "devices/input_source.hpp"

namespace gantry::devices {

using Bytes = std::vector<std::byte>;

/// What EtherCAT says of an exchange in its own terms. Carried to people (snapshots, topics, reports): nothing in the
/// loop or above it decides by it. A bus of another kind leaves it empty.
struct EthercatFigures {
  std::uint16_t working_counter = 0, expected = 0;
  std::uint16_t al_states = 0;  ///< AL states of all stations OR-ed (BRD 0130h)
};

/// What one cyclic exchange gave, whatever the bus (docs/decisions/015).
struct Exchange {
  /// FrameLost: not all that was sent came back. TooFewTookPart: it did, but not everybody took part; also when
  /// nobody did. TooManyTookPart: somebody took part that should not. BusDown: no link.
  Fault fault = Fault::None;
  bool inputs_fresh = false;  ///< all inputs are of this exchange; stale ones are the last good ones, unchanged
  bool complete = false;      ///< as many took part as belong to the bus
  bool operational = false;   ///< every station says that it is operational
  std::int32_t detail = 0;    ///< a figure for people to the verdict, or to `operational`, in the terms of the fault
  std::uint64_t reference_ns = 0;  ///< the bus's own clock in this exchange, which cycles keep to; 0: it has none
  StationId clock_station;         ///< whose clock was looked at in this cycle, in turn
  bool clock_seen = false;         ///< one was
  std::int32_t clock_ns = 0;       ///< that clock minus the reference
  EthercatFigures ethercat;
};

/// One byte of a station's outputs made otherwise: what is kept of it, and what is set.
struct ImageChange {
  StationId station;
  std::uint16_t byte = 0;
  std::byte keep{0}, set{0};
  constexpr void apply(std::span<std::byte> outputs) const noexcept {
    if (byte < outputs.size()) outputs[byte] = (outputs[byte] & keep) | set;
  }
};

/// Frames that one exchange takes at most.
inline constexpr std::size_t kMaxCyclicFrames = 24;

class FieldBus {
 public:
  virtual ~FieldBus() = default;
  /// Scan, identities, configuration, states up to where cyclic exchange may begin. Bounded in time; Fault
  /// 1xx with the station's name.
  virtual Result<void> bring_up() = 0;
  /// Asks for operation; the caller goes on exchanging and watches Exchange::operational. From the first exchange() on,
  /// blocking calls ride along in the cyclic frames (under a virtual clock they go out by themselves: one thread owns
  /// everything there). This one waits for that exchange, 0.1 s at most: a loop in a thread of its own may have been
  /// started just now.
  virtual Result<void> request_operation() = 0;
  /// Which station is not operational, and why: Fault::StationLeftOp with what it says as text. Blocking.
  virtual Result<void> check_operation() = 0;
  /// First instant at or after `not_before`, on the machine's clock, at which a cycle should begin so that the stations
  /// act half a cycle later. Where the bus has no clock to keep to: `not_before`.
  [[nodiscard]] virtual Time first_cycle(Time not_before) const noexcept = 0;
  /// Leaves cyclic operation in order: outputs safe, then down, where every station that answers is when this returns.
  /// Blocking, bounded in time. The caller has stopped exchanging.
  virtual void shut_down() = 0;
  virtual Result<Bytes> read_object(StationId station, config::ObjectAddress address) = 0;
  virtual Result<void> write_object(StationId station, config::ObjectAddress address,
                                    std::span<const std::byte> value) = 0;

  /// Process data of one station, valid from bring_up() on; addresses do not move.
  [[nodiscard]] virtual std::span<std::byte> outputs(StationId station) noexcept = 0;
  [[nodiscard]] virtual std::span<const std::byte> inputs(StationId station) const noexcept = 0;
  /// The inputs of this station are of the last exchange. RT.
  [[nodiscard]] virtual bool fresh(StationId station) const noexcept = 0;
  /// How an object that a station's profile has among its inputs comes from it. RT.
  [[nodiscard]] virtual InputSource source(StationId /*station*/, config::ObjectAddress /*input*/) const noexcept {
    return InputSource::EveryCycle;
  }
  /// Whether the station has this object of its start-up rows; one that has not goes by its own value. RT.
  [[nodiscard]] virtual bool has_row(StationId /*station*/, config::ObjectAddress /*row*/) const noexcept {
    return true;
  }
  /// One cycle: sends the image and takes what comes back until `deadline`. RT.
  virtual Exchange exchange(Time deadline) noexcept = 0;
  /// Announces the deadline of the next exchange(), when a cycle is done and time is left. Without it, or with another
  /// deadline, exchange() works all the same and takes a little longer. RT.
  virtual void arm(Time /*deadline*/) noexcept {}
  /// Writes the frames that carry the image as it stands, but for `changes`, for somebody else to send at any later
  /// time (their answers are never taken for those of an exchange). How many; 0 before bring_up(). RT.
  virtual std::size_t spare_frames(std::span<const ImageChange> changes, std::span<FrameBytes> frames) noexcept = 0;
};

}  // namespace gantry::devices
