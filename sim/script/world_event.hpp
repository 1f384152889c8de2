// What a world script can make happen, and when. Read by sim/script/script.hpp, done by the world (board, buttons,
// obstacles) and by the virtual machine (bus, drives).
#pragma once
#include <cstdint>
#include <string>

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

enum class ActionKind : std::uint8_t {
  // of the bus and its drives
  CutLink,          ///< the cable that leads to `station` (of the first one: the master's own)
  HealLink,         ///< the same
  LoseFrames,       ///< the next `count`
  CorruptFrames,    ///< bits of the next `count` are hit: a wrong FCS
  CorruptHeaders,   ///< a byte in the headers of the next `count` is wrong under a right FCS
  DuplicateFrames,  ///< the next `count` come back twice
  ReorderFrames,    ///< the next `count` come back behind the one that follows
  DelayFrames,      ///< the next `count` come back `hold` later
  Noise,            ///< from now on at random, as `noise` says
  Drift,            ///< `station`'s clock gains `amount` ppm
  Jitter,           ///< ... and looks at the wire up to `hold` off
  CountErrors,      ///< `station` has seen `count` bad frames at port `code`
  StickStatusword,  ///< `axis` shows what 6041h shows now, until FreeStatusword
  FreeStatusword,
  IgnoreWrites,  ///< `station` says yes to SDO downloads and keeps its values (`object`; index 0: all), until
                 ///< HeedWrites
  HeedWrites,
  SetObject,   ///< `object` of `station` becomes `amount`: what an input terminal measures
  DriveFault,  ///< `axis` raises `code`, in its drive number `count`
  Stall,       ///< `axis` is held by an obstacle; until Release
  Release,
  PowerOff,  ///< `station` loses its supply, until PowerOn
  PowerOn,
  PowerCycle,  ///< ... and has it back after `hold`
  // of the world
  RemoveMark,      ///< `name`
  MoveMark,        ///< `name` by `at`
  Stain,           ///< dirt of `diameter` and `grey` at `at` (board frame), or at `at` from the mark `name`
  AddObstacle,     ///< a box `name` of `size` centred at `at`, machine frame
  RemoveObstacle,  ///< `name`
  Press,           ///< button `input` for `hold`
  SetInput,        ///< `input` to `on`
  CameraDead,
  CameraAlive,
};

struct Action {
  ActionKind kind{};
  std::string name;
  StationId station;
  AxisId axis;
  config::Input input{};
  bool on = false;
  std::uint32_t code = 0, count = 0;
  Vec3 at, size;
  double diameter = 0, grey = 0, amount = 0;
  config::ObjectAddress object;
  LineNoise noise;
  Time hold = milliseconds(200);
};

constexpr bool of_the_bus(ActionKind k) { return k <= ActionKind::PowerCycle; }

struct ScriptEntry {
  Trigger trigger;
  Action action;
  std::string where;  ///< "crash.yaml:3:3"
  std::string text;   ///< "lose_frames at cycle 12000"
};

}  // namespace gantry::sim
