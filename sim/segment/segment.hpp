// The virtual EtherCAT segment: a line of software stations that answers raw frames like a ring of real ones. It stands
// behind FramePort (sim/segment/segment_port.hpp) or behind a network interface and knows nothing of who asks.
//   Segment segment(machine, clock);
//   segment.process(frame);          // in place; false when the frame does not come back
//   segment.motor(axis).position();  // the plant, for the world
// Time is lazy: when a frame arrives, every SYNC0 event since the last one happens first, each at its own instant
// (motors move, the world is called, inputs are sampled, outputs are taken), then the datagrams are served. One thread
// owns a segment. Cyclic processing does not allocate; mailbox transactions may.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "sim/drive/drive_memory.hpp"
#include "sim/drive/motor.hpp"
#include "sim/segment/datagram.hpp"
#include "sim/segment/frame_faults.hpp"
#include "sim/segment/segment_host.hpp"

namespace gantry::sim {

class Drive402;
class Station;
struct StationHabits;
struct StationTiming;

class Segment {
 public:
  /// Stations of the machine that hang on EtherCAT, in the order of their positions, powered and in INIT. Both
  /// arguments must outlive the segment.
  Segment(const config::Machine& machine, Clock& clock);
  ~Segment();
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  /// As the constructor left it, at clock.now(): stations and motors as new, cables whole, no faults, counts at 0. The
  /// world, the timing and where stations hang stay as the host has set them. A small part of the constructor's cost:
  /// whoever needs thousands of new segments takes this one again.
  void renew();

  void set_world(WorldHook* world) noexcept { world_ = world; }
  void set_timing(const StationTiming& timing) noexcept;
  /// What a station does otherwise than its profile can say. It begins anew with that.
  void set_habits(StationId station, const StationHabits& habits);
  /// The station's cable leads to `port` (1, 2 or 3) of `parent` instead of to port 1 of the station before it. Frames
  /// go through ports 3, 1, 2 in this order; positions have to agree with that. False: they would not.
  bool hang(StationId station, StationId parent, int port) noexcept;

  /// A whole Ethernet frame (without FCS) goes through the ring and becomes in place what comes back. False: nothing
  /// comes back (malformed, not EtherCAT, lost by script, no station reachable).
  bool process(std::span<std::byte> frame) noexcept;
  /// What is to happen to the frame that process() gave back last: how late it comes, and how often.
  [[nodiscard]] const FrameFate& fate() const noexcept { return fate_; }
  /// From the first station's processing unit out to the end of the line and back.
  [[nodiscard]] Time round_trip() const noexcept { return round_trip_; }
  /// Brings every station up to clock.now() without a frame: for a host that nobody talks to, and before the world is
  /// read.
  void advance() noexcept;
  /// When advance() has something to do next: a cycle of a station. kNever: no station has power.
  [[nodiscard]] Time next_tick() const noexcept;

  // --- The plant, for the world ---
  /// `drive`: place in config::Axis::drives (a gantry axis has two). Axes that are not on this segment have no motor:
  /// asking for one is the caller's mistake.
  Motor& motor(AxisId axis, int drive = 0) noexcept;
  [[nodiscard]] const Motor& motor(AxisId axis, int drive = 0) const noexcept;
  [[nodiscard]] bool has_motor(AxisId axis, int drive = 0) const noexcept;
  /// Output bits of a station that is no drive as they stand at its terminals; 0 unless it is in OP.
  [[nodiscard]] std::uint16_t io_outputs(StationId station) const noexcept;
  /// The station is in OP, so that its outputs are what the master commands.
  [[nodiscard]] bool in_operation(StationId station) const noexcept;
  /// Levels at its input terminals, seen by the master from the next sample on.
  void set_io_inputs(StationId station, std::uint16_t bits) noexcept;
  [[nodiscard]] DriveMemory memory(AxisId axis, int drive = 0) const noexcept;
  void restore(AxisId axis, int drive, const DriveMemory& memory) noexcept;

  // --- What a script may do to it ---
  /// Link `i` leads to station i of the ring, from the station before it (or where hang() said); link 0 is the
  /// master's own cable. The ports on both sides close.
  void cut_link(int link) noexcept;
  void heal_link(int link) noexcept;
  /// A station without power breaks the line behind it. When it returns it is in INIT, its registers and its
  /// dictionary are new, and its counters read 0 where the motors stand.
  void power_off(StationId station) noexcept;
  void power_on(StationId station);
  /// Off now, on again when `dark` has passed.
  void power_cycle(StationId station, Time dark = milliseconds(200));
  /// The drive shows `code` in 603Fh and does what its profile's error row says (fault or warning).
  void drive_fault(AxisId axis, int drive, std::uint32_t code);
  /// Frames that are lost, hit, delayed ...
  [[nodiscard]] FrameFaults& faults() noexcept { return faults_; }
  /// The next n frames are lost on the cable.
  void lose_frames(int n) noexcept { faults_.lose(n); }
  /// Rate of a station's own clock against the machine's, parts per million.
  void set_clock_drift(StationId station, double ppm) noexcept;
  /// Each look of a station's clock at the wire is off by up to this, seeded by the station's place.
  void set_clock_jitter(StationId station, std::uint32_t ns) noexcept;

  /// The station counts bad frames at a port (a connector that goes bad).
  void count_errors(StationId station, int port, int frames) noexcept;
  /// 6041h stays at what it shows now, or lives again.
  void stick_statusword(AxisId axis, int drive, bool stuck) noexcept;
  /// SDO downloads are answered and change nothing: of one object (index 0: of all), or of none any more.
  void ignore_writes(StationId station, std::optional<config::ObjectAddress> object) noexcept;
  /// From now on so much passes between a request to its mailbox and the answer.
  void slow_mailbox(StationId station, Time by) noexcept;
  /// What an input terminal measures. False: the station has no such object.
  bool set_object(StationId station, config::ObjectAddress object, std::int64_t value) noexcept;

  // --- For reports and tests ---
  [[nodiscard]] std::uint64_t cycles() const noexcept { return cycles_; }  ///< SYNC0 events of the segment so far
  [[nodiscard]] std::uint64_t frames() const noexcept { return frames_; }  ///< frames that went round
  [[nodiscard]] bool link_up() const noexcept;                             ///< of the master's own cable
  [[nodiscard]] int station_count() const noexcept { return static_cast<int>(ring_.size()); }
  [[nodiscard]] Station& station(int position) noexcept { return *ring_[static_cast<std::size_t>(position)]; }

 private:
  struct AxisDrive {
    int position = -1, slot = 0;  ///< place in the ring (-1: not on this segment), axis of the station
    Motor* motor = nullptr;
  };
  [[nodiscard]] const AxisDrive& find(AxisId axis, int drive) const noexcept;
  [[nodiscard]] Drive402* drive(AxisId axis, int drive) const noexcept;
  [[nodiscard]] int position_of(StationId station) const noexcept;
  void advance_to(Time now) noexcept;
  void power_returns() noexcept;
  void set_return(int position, Time at) noexcept;
  void tick_group(Time at) noexcept;
  void count_hit(int place) noexcept;
  void spoil_header(std::span<std::byte> frame) noexcept;
  void update_links() noexcept;
  Time trace(int station, Time entry) noexcept;

  const config::Machine& machine_;
  Clock& clock_;
  WorldHook* world_ = nullptr;
  std::vector<std::unique_ptr<Station>> ring_;
  std::vector<StationId> ids_;                  ///< by position
  std::vector<std::vector<AxisDrive>> drives_;  ///< by AxisId, then drive of the axis
  std::vector<std::unique_ptr<Motor>> motors_;  ///< one a drive; its station commands it
  /// Where a station's port 0 is plugged in, and what its own ports lead to (-1: nothing).
  struct Node {
    int parent = -1, port = 1;
    std::array<int, 4> child{-1, -1, -1, -1};
  };
  std::vector<Node> nodes_;  ///< by position
  /// A station that frames reach, and when they come to it, counted from the first one.
  struct Hop {
    Station* station = nullptr;
    Time entry{};
  };
  std::vector<Hop> route_;              ///< in the order in which a frame passes
  bool route_ends_nowhere_ = false;     ///< an open port without a cable: frames do not come back
  bool passes_foreign_frames_ = false;  ///< every station on the way lets them through (0100h)
  Time round_trip_{};
  std::vector<bool> link_cut_;       ///< by link
  std::vector<Time> power_returns_;  ///< by position; kNever: it is not to return by itself
  Time next_return_ = kNever;        ///< the first of them
  std::uint64_t cycles_ = 0, frames_ = 0;
  std::vector<Datagram> datagrams_;  ///< of the frame that goes round
  FrameFaults faults_;
  FrameFate fate_;
};

}  // namespace gantry::sim
