// What a world script can make happen, and when. Read by sim/script/script.hpp; the world does what concerns board,
// buttons and obstacles, sim/machine/bus_actions.hpp what concerns bus and drives.
//   ScriptEntry e{{Trigger::Kind::NthDot, 7}, BusAction{act::DriveFault{x, 0, 0x7500}}, "crash.yaml:3:3", "..."};
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <variant>

#include "config/machine.hpp"
#include "core/clock.hpp"
#include "core/id.hpp"
#include "core/vec.hpp"
#include "sim/segment/frame_faults.hpp"

namespace gantry::sim {

/// The instant that an entry waits for. Everything here is the world's own view: it does not know blocks or steps.
struct Trigger {
  enum class Kind : std::uint8_t {
    Now,          ///< at the next sync
    JobStart,     ///< begin_job()
    Cycle,        ///< SYNC0 number `count` of the segment
    NthDot,       ///< the valve begins its `count`-th dot of the job
    NthBead,      ///< ... bead
    FeatureId,    ///< the valve opens at the start of the feature `name`
    MarkExposed,  ///< the camera is triggered over the mark `name`, before it sees anything
    NthTouch,     ///< the probe meets a surface for the `count`-th time in the job
  } kind = Kind::Now;
  std::uint64_t count = 0;
  std::string name;
  Time after{};  ///< and then this much later
};

namespace act {

// Of the bus and its drives. `drive` counts the drives of an axis; a gantry axis has two.
struct CutLink {
  StationId station;  ///< the cable that leads to it; of the first one the master's own
};
struct HealLink {
  StationId station;
};
struct LoseFrames {
  int count = 0;  ///< of the next frames; so in those below
};
struct CorruptFrames {
  int count = 0;  ///< bits are hit: a wrong FCS
};
struct CorruptHeaders {
  int count = 0;  ///< a wrong byte under a right FCS
};
struct DuplicateFrames {
  int count = 0;
};
struct ReorderFrames {
  int count = 0;  ///< they come back behind the one that follows
};
struct ForeignFrames {
  int count = 0;  ///< behind each of them one of another master comes in
};
struct DelayFrames {
  int count = 0;
  Time by{};
};
struct Noise {
  LineNoise shares;  ///< from now on at random
};
struct Drift {
  StationId station;
  double ppm = 0;  ///< its clock gains this
};
struct Jitter {
  StationId station;
  Time by{};  ///< its clock looks at the wire up to this much off
};
struct CountErrors {
  StationId station;
  int port = 0, count = 0;
};
struct StickStatusword {
  AxisId axis;
  int drive = 0;
  bool stuck = true;
};
struct IgnoreWrites {
  StationId station;
  std::optional<config::ObjectAddress> object;  ///< nothing: all of them
};
struct SlowMailbox {
  StationId station;
  Time by{};
};
struct HeedWrites {
  StationId station;
};
struct SetObject {
  StationId station;
  config::ObjectAddress object;
  double value = 0;
};
struct DriveFault {
  AxisId axis;
  int drive = 0;
  std::uint32_t code = 0;  ///< as it stands in 603Fh
};
struct Stall {
  AxisId axis;
  bool held = true;  ///< something holds the axis
};
struct SlipBrake {
  AxisId axis;
  std::optional<int> drive{};  ///< one side of a gantry axis alone; left out: all that the axis has
  double per_s = 0;            ///< while its drives have no torque, in mm or rad; 0: the brake holds again
};
struct PowerOff {
  StationId station;
};
struct PowerOn {
  StationId station;
};
struct PowerCycle {
  StationId station;
  Time dark{};
};
struct EmergencyStop {
  bool pressed = true;  ///< all drives lose their common supply, and safety_ok goes; released: both come back
};

// Of the world. `input` is a bit of the loop's input word.
struct RemoveMark {
  std::string name;
};
struct MoveMark {
  std::string name;
  Vec2 by;  ///< in the board's frame
};
struct Stain {
  std::string from;  ///< a mark that `by` counts from; empty: the board's origin
  Vec2 by;
  double diameter = 0, grey = 30;
};
struct AddObstacle {
  std::string name;
  Vec3 centre, size;  ///< a box in the machine frame
};
struct RemoveObstacle {
  std::string name;
};
struct Press {
  unsigned input = 0;
  Time hold{};
};
struct SetInput {
  unsigned input = 0;
  bool on = false;
};
struct BreakWire {
  unsigned input = 0;  ///< its contact reads 0 from now on
};
struct SetCamera {
  bool alive = true;
};

}  // namespace act

using BusAction =
    std::variant<act::CutLink, act::HealLink, act::LoseFrames, act::CorruptFrames, act::CorruptHeaders,
                 act::DuplicateFrames, act::ReorderFrames, act::ForeignFrames, act::DelayFrames, act::Noise, act::Drift,
                 act::Jitter, act::CountErrors, act::StickStatusword, act::IgnoreWrites, act::HeedWrites,
                 act::SlowMailbox, act::SetObject, act::DriveFault, act::Stall, act::SlipBrake, act::PowerOff,
                 act::PowerOn, act::PowerCycle, act::EmergencyStop>;
using WorldAction = std::variant<act::RemoveMark, act::MoveMark, act::Stain, act::AddObstacle, act::RemoveObstacle,
                                 act::Press, act::SetInput, act::BreakWire, act::SetCamera>;
using Action = std::variant<BusAction, WorldAction>;

struct ScriptEntry {
  Trigger trigger;
  Action action;
  std::string where;  ///< "crash.yaml:3:3"
  std::string text;   ///< "lose_frames at cycle 12000"
};

}  // namespace gantry::sim
