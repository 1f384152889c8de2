#include "sim/script/actions.hpp"

#include <cmath>

namespace gantry::sim {

namespace {

using config::Dimension;
using config::Field;
using config::kOptional;
using config::kRequired;
using E = Entry;

constexpr config::Range kNear{-1e4, 1e4};  ///< mm; what stands farther off is not in the machine

Field<E> object_key(config::Need need, const char* what) {
  return {{"object", need, what, {config::ValueShape::Kind::Address, {}, config::kAny, {}, {}, {}}},
          [](const config::Node& node, E& to, config::Mistakes& mistakes) {
            if (const auto a = config::read_address(node, mistakes))
              to.object = {config::ObjectAddress{a->first, a->second}, node.location};
          }};
}
Field<E> share(const char* key, double LineNoise::*to, const char* what) {
  const config::ValueShape shape{config::ValueShape::Kind::Number, {Dimension::None}, {0, 1}, {}, {}, {}};
  return {{key, kOptional, what, shape}, [to, shape](const config::Node& node, E& e, config::Mistakes& mistakes) {
            if (const auto v = config::read_quantity(node, shape, mistakes)) e.noise.*to = v->value;
          }};
}

/// An action of one station, or of the next so many frames.
template <class A>
Action of_station(const E& e, Names& names) {
  return BusAction{A{names.station(e.station)}};
}
template <class A>
Action of_frames(const E& e, Names&) {
  return BusAction{A{e.count}};
}

std::vector<ActionRow> table() {
  const auto axis = config::text("axis", &E::axis, kRequired, "axis of the machine file");
  const auto station = config::text("station", &E::station, kRequired, "station of the machine file");
  const auto name = config::text("name", &E::name, kRequired, "of the mark or obstacle");
  const auto input = config::text("input", &E::input, kRequired, "input of the machine file: start, door_closed ...");
  const auto count = config::integer("count", &E::count, {1, 1e6}, kRequired, "how many of the next frames");
  const auto drive = config::integer("drive", &E::drive, {0, 1}, kOptional, "which side of a gantry axis");
  const auto by_mm = config::point("by", &E::by, kNear, kRequired, "[1 mm, 0 mm] in the board's frame");
  using namespace act;
  return {
      {"cut_link", {station}, of_station<CutLink>},
      {"heal_link", {station}, of_station<HealLink>},
      {"lose_frames", {count}, of_frames<LoseFrames>},
      {"corrupt_frames", {count}, of_frames<CorruptFrames>},
      {"corrupt_headers", {count}, of_frames<CorruptHeaders>},
      {"duplicate_frames", {count}, of_frames<DuplicateFrames>},
      {"reorder_frames", {count}, of_frames<ReorderFrames>},
      {"foreign_frames", {count}, of_frames<ForeignFrames>},
      {"delay_frames",
       {count, config::number("by", &E::by_s, Dimension::Time, {1e-9, 10}, kRequired, "how much later they come")},
       [](const E& e, Names&) -> Action {
         return BusAction{DelayFrames{e.count, time_of(e.by_s)}};
       }},
      {"noise",
       {share("loss", &LineNoise::loss, "share of frames that are lost"),
        share("corrupt", &LineNoise::corrupt, "that are hit"),
        share("header", &LineNoise::header, "with a wrong header"),
        share("duplicate", &LineNoise::duplicate, "that come twice"),
        share("delay", &LineNoise::delay, "that come up to 2 ms late"),
        share("reorder", &LineNoise::reorder, "out of order"),
        config::integer("seed", &E::seed, {0, 4e9}, kOptional, "of the chance")},
       [](const E& e, Names&) -> Action {
         Noise noise{e.noise};
         noise.shares.seed = e.seed;
         return BusAction{noise};
       }},
      {"drift",
       {station, config::number("ppm", &E::ppm, Dimension::None, {-1000, 1000}, kRequired, "its clock gains")},
       [](const E& e, Names& n) -> Action {
         return BusAction{Drift{n.station(e.station), e.ppm}};
       }},
      {"jitter",
       {station, config::number("by", &E::by_s, Dimension::Time, {0, 1e-3}, kRequired, "at most, to either side")},
       [](const E& e, Names& n) -> Action {
         return BusAction{Jitter{n.station(e.station), time_of(e.by_s)}};
       }},
      {"count_errors",
       {station, config::integer("port", &E::port, {0, 1}, kRequired, "0 towards the master, 1 away from it"),
        config::integer("count", &E::count, {1, 255}, kRequired, "frames with a wrong FCS")},
       [](const E& e, Names& n) -> Action {
         return BusAction{CountErrors{n.station(e.station), e.port, e.count}};
       }},
      {"stick_statusword",
       {axis, drive},
       [](const E& e, Names& n) -> Action {
         const AxisId id = n.axis(e.axis);
         return BusAction{StickStatusword{id, n.drive(id, e.drive), true}};
       }},
      {"free_statusword",
       {axis, drive},
       [](const E& e, Names& n) -> Action {
         const AxisId id = n.axis(e.axis);
         return BusAction{StickStatusword{id, n.drive(id, e.drive), false}};
       }},
      {"ignore_writes",
       {station, object_key(kOptional, "one object alone")},
       [](const E& e, Names& n) -> Action {
         IgnoreWrites a{n.station(e.station), {}};
         if (e.object.given()) a.object = n.object(a.station, e.object);
         return BusAction{a};
       }},
      {"heed_writes", {station}, of_station<HeedWrites>},
      {"slow_mailbox",
       {station, config::number("by", &E::by_s, Dimension::Time, {0, 3600}, kRequired, "from a request to its answer")},
       [](const E& e, Names& n) -> Action {
         return BusAction{SlowMailbox{n.station(e.station), time_of(e.by_s)}};
       }},
      {"set_object",
       {station, object_key(kRequired, "index:sub"),
        config::number("value", &E::value, Dimension::None, {-2147483648.0, 4294967295.0}, kRequired, "what it reads")},
       [](const E& e, Names& n) -> Action {
         const StationId id = n.station(e.station);
         return BusAction{SetObject{id, n.object(id, e.object), e.value}};
       }},
      {"drive_fault",
       {axis, drive, config::integer("code", &E::code, {1, 0xFFFF}, kRequired, "as it stands in 603Fh")},
       [](const E& e, Names& n) -> Action {
         const AxisId id = n.axis(e.axis);
         return BusAction{DriveFault{id, n.drive(id, e.drive), e.code}};
       }},
      {"stall",
       {axis},
       [](const E& e, Names& n) -> Action {
         return BusAction{Stall{n.axis(e.axis), true}};
       }},
      {"release",
       {axis},
       [](const E& e, Names& n) -> Action {
         return BusAction{Stall{n.axis(e.axis), false}};
       }},
      {"slip_brake",
       {axis, drive,
        config::number("speed", &E::value, Dimension::Speed, {-100, 100}, kRequired, "0 mm/s: it holds again")},
       [](const E& e, Names& n) -> Action {
         SlipBrake a{n.axis(e.axis), {}, e.value};
         if (e.drive.given()) a.drive = n.drive(a.axis, e.drive);
         return BusAction{a};
       }},
      {"power_off", {station}, of_station<PowerOff>},
      {"power_on", {station}, of_station<PowerOn>},
      {"power_cycle",
       {station, config::number("dark", &E::dark_s, Dimension::Time, {1e-3, 3600}, kOptional, "how long it is off")},
       [](const E& e, Names& n) -> Action {
         return BusAction{PowerCycle{n.station(e.station), time_of(e.dark_s)}};
       }},
      {"emergency_stop", {}, [](const E&, Names&) -> Action { return BusAction{EmergencyStop{true}}; }},
      {"emergency_release", {}, [](const E&, Names&) -> Action { return BusAction{EmergencyStop{false}}; }},
      {"remove_mark", {name}, [](const E& e, Names&) -> Action { return WorldAction{RemoveMark{e.name.value}}; }},
      {"move_mark",
       {name, by_mm},
       [](const E& e, Names&) -> Action {
         return WorldAction{MoveMark{e.name.value, e.by}};
       }},
      {"stain",
       {config::text("name", &E::name, kOptional, "of a mark that `by` counts from; else from the board's origin"),
        by_mm, config::number("diameter", &E::diameter, Dimension::Length, {0.001, 1000}, kRequired, "of the blot"),
        config::number("grey", &E::grey, Dimension::None, {0, 255}, kOptional, "grey level")},
       [](const E& e, Names&) -> Action {
         return WorldAction{act::Stain{e.name.value, e.by, e.diameter, e.grey}};
       }},
      {"add_obstacle",
       {name, config::point("centre", &E::centre, kNear, kRequired, "in the machine frame"),
        config::point("size", &E::size, {0.001, 10000}, kRequired, "edges of the box")},
       [](const E& e, Names&) -> Action {
         return WorldAction{AddObstacle{e.name.value, e.centre, e.size}};
       }},
      {"remove_obstacle",
       {name},
       [](const E& e, Names&) -> Action { return WorldAction{RemoveObstacle{e.name.value}}; }},
      {"press",
       {input, config::number("hold", &E::hold_s, Dimension::Time, {0.001, 3600}, kOptional, "how long")},
       [](const E& e, Names& n) -> Action {
         return WorldAction{Press{n.button(e.input), time_of(e.hold_s)}};
       }},
      {"set_input",
       {input, config::flag("on", &E::on, kRequired, "its new level")},
       [](const E& e, Names& n) -> Action {
         return WorldAction{SetInput{n.input(e.input), e.on}};
       }},
      {"break_wire", {input}, [](const E& e, Names& n) -> Action { return WorldAction{BreakWire{n.input(e.input)}}; }},
      {"camera_dead", {}, [](const E&, Names&) -> Action { return WorldAction{SetCamera{false}}; }},
      {"camera_alive", {}, [](const E&, Names&) -> Action { return WorldAction{SetCamera{true}}; }},
  };
}

}  // namespace

const std::vector<ActionRow>& actions() {
  static const std::vector<ActionRow> kTable = table();
  return kTable;
}

Time time_of(double seconds) { return Time(static_cast<std::int64_t>(std::llround(seconds * 1e9))); }

}  // namespace gantry::sim
