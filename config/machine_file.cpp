#include "config/machine_file.hpp"

#include "config/formats.hpp"

namespace gantry::config {
namespace written {
namespace {

using D = Dimension;
constexpr Range kPositive{1e-9, 1e9};
constexpr Range kLength{-1e5, 1e5};
constexpr Range kHalfTurn{units::rad(-180), units::rad(180)};

const std::vector<D> kPosition{D::Length, D::Angle};
const std::vector<D> kSpeed{D::Speed, D::AngularSpeed};
const std::vector<D> kAcceleration{D::Acceleration, D::AngularAcceleration};
const std::vector<D> kJerk{D::Jerk, D::AngularJerk};

/// The same field; `to` learns where its value stands.
template <class T>
Field<T> placed(Field<T> field, Location T::*location) {
  return {std::move(field.row), [read = std::move(field.read), location](const Node& node, T& to, Mistakes& mistakes) {
            to.*location = node.location;
            read(node, to, mistakes);
          }};
}

/// `run_current: 2.1 A`, or one value for each axis of the station.
Field<StationRow> settings(std::string key, std::string doc) {
  const ValueShape value{ValueShape::Kind::Setting, {}, kAny, {}, {}, {}};
  return {{std::move(key), kOptional, std::move(doc), {ValueShape::Kind::Named, {}, {0, 100}, {}, {}, {value}}},
          [](const Node& node, StationRow& to, Mistakes& mistakes) {
            if (!expect_map(node, "names with values", mistakes)) return;
            for (std::size_t i = 0; i < node.keys.size(); ++i) {
              const Node& item = node.items[i];
              if (!expect_name(node.keys[i], mistakes) || item.kind == Node::Kind::Refused) continue;
              SettingRow& row = to.parameters.emplace_back(SettingRow{node.keys[i].text, node.keys[i].location, {}});
              row.unread = item.kind == Node::Kind::Sequence && !expect_list(item, {1, 8}, mistakes);
              if (row.unread) continue;
              for (const Node& each : item.kind == Node::Kind::Sequence ? item.items : std::vector{item})
                if (auto text = read_scalar(each, "a value such as '2.1 A' or 10000", mistakes))
                  row.values.push_back({std::move(*text), each.location});
            }
          }};
}

Field<StationRow> declared(std::string key, std::string doc) {
  const ValueShape name{ValueShape::Kind::Name, {}, kAny, {}, {}, {}};
  return {{std::move(key), kOptional, std::move(doc), {ValueShape::Kind::List, {}, {0, 100}, {}, {}, {name}}},
          [name](const Node& node, StationRow& to, Mistakes& mistakes) {
            if (!expect_list(node, {0, 100}, mistakes)) return;
            for (const Node& each : node.items)
              if (auto word = read_word(each, name, mistakes)) to.declared.push_back({std::move(*word), each.location});
          }};
}

const Fields<InputsRow> kInputsOfDrive{
    integer("negative_limit", &InputsRow::negative_limit, {0, 31}, kOptional, "bit of 60FDh"),
    integer("positive_limit", &InputsRow::positive_limit, {0, 31}, kOptional, "bit of 60FDh"),
    integer("home", &InputsRow::home, {0, 31}, kOptional, "bit of 60FDh"),
};

const Fields<StationRow> kStation{
    name_of("profile", &StationRow::profile, kRequired, "a file of ../drives or ../devices, without .yaml"),
    integer("position", &StationRow::position, {0, 127}, kRequired, "place in the ring, 0 first; node id on CANopen"),
    placed(integer("alias", &StationRow::alias, {0, 65535}, kOptional, "station alias; 0: not checked"),
           &StationRow::alias_location),
    settings("parameters", "other values of the profile's parameters; one for all axes of the station, or a list"),
    declared("declared",
             "parameters, and rows that homing sets, whose object the station does not have: you vouch for them"),
    object("inputs", &StationRow::inputs, kInputsOfDrive, kOptional, "other bits of 60FDh than the profile's"),
    flag("emergency_stop_elsewhere", &StationRow::emergency_stop_elsewhere, kOptional,
         "the probe takes this drive's emergency stop input: the emergency stop is wired outside of it"),
};

const Fields<DriveRow> kDrive{
    name_of("station", &DriveRow::station, kRequired, "one of `stations`"),
    integer("slot", &DriveRow::slot, {0, 7}, kOptional, "axis of the station, 0 first"),
    flag("invert", &DriveRow::invert, kOptional, "counts rise while the axis coordinate falls"),
};

const Fields<HomingRow> kHoming{
    integer("order", &HomingRow::order, {0, 15}, kRequired, "axes of the lowest order go first, equal ones together"),
    integer("method", &HomingRow::method, {1, 37}, kRequired, "value of 6098h"),
    quantity("fast", &HomingRow::fast, kSpeed, kRequired, "speed towards the switch"),
    quantity("slow", &HomingRow::slow, kSpeed, kRequired, "speed over the switch's edge"),
    quantity("acceleration", &HomingRow::acceleration, kAcceleration, kRequired, "of both"),
    quantity("position", &HomingRow::position, kPosition, kRequired, "axis coordinate at the switch's edge"),
    number("timeout", &HomingRow::timeout_s, D::Time, {1, 3600}, kOptional, "given up after this"),
    quantity(
        "rack_max", &HomingRow::rack_max, kPosition, kOptional,
        "gantry axis: how much farther one side may go than the other in homing: what the beam bears; else 20 ms at "
        "v_max and braking from there"),
    quantity("square_max", &HomingRow::square_max, kPosition, kOptional,
             "gantry axis: what homing takes out of its sides' difference; else 5 times skew_max"),
    flag("limits_unseen", &HomingRow::limits_unseen, kOptional,
         "it homes although the controller does not see its limit switches: the drive alone stops at them"),
};

const Fields<FollowingRow> kFollowing{
    quantity("base", &FollowingRow::base, kPosition, kRequired, "allowed following error at rest"),
    number("per_speed", &FollowingRow::per_speed_s, D::Time, {0, 1}, kOptional, "added a unit of speed"),
};

const Fields<AxisRow> kAxis{
    choice("kind", &AxisRow::kind,
           Choices<AxisKind>{{"streamed", AxisKind::Streamed}, {"positioned", AxisKind::Positioned}}, kOptional,
           "streamed: a target every cycle; positioned: the drive moves by itself"),
    list("drives", &AxisRow::drives, kDrive, {1, 2}, kRequired, "one drive, or two of one coordinate (gantry axis)"),
    quantity("per_rev", &AxisRow::per_rev, kPosition, kRequired, "travel of one motor revolution; deg: a rotary axis"),
    quantities("travel", &AxisRow::travel, 2, kPosition, kRequired, "soft limits"),
    quantity("v_max", &AxisRow::v_max, kSpeed, kRequired, "largest speed"),
    quantity("a_max", &AxisRow::a_max, kAcceleration, kRequired, "largest acceleration"),
    quantity("j_max", &AxisRow::j_max, kJerk, kRequired, "largest jerk"),
    object("following", &AxisRow::following, kFollowing, kOptional, "following error window; closed loop only"),
    quantity("skew_max", &AxisRow::skew_max, kPosition, kOptional, "gantry axis: allowed difference of its sides"),
    placed(number("response_delay", &AxisRow::response_delay_s, D::Time, {0, 0.05}, kOptional,
                  "how far the axis lags its command; compensated"),
           &AxisRow::response_delay_location),
    quantity("path_error", &AxisRow::path_error, kPosition, kOptional,
             "how far the axis may be off its path in motion: kept from bodies over and above `clearance`; else 0"),
    placed(flag("self_locking", &AxisRow::self_locking, kOptional,
                "open loop: without torque the axis stays where it is (screw, worm), and keeps its reference"),
           &AxisRow::self_locking_location),
    object("homing", &AxisRow::homing, kHoming, kOptional, "how the axis is referenced"),
};

const Fields<RolesRow> kRoles{
    name_of("x", &RolesRow::x, kRequired, "axis that carries the head along X"),
    name_of("y", &RolesRow::y, kRequired, "axis that carries the head along Y"),
    name_of("z", &RolesRow::z, kRequired, "axis that carries the head along Z, up positive"),
    name_of("turn", &RolesRow::turn, kOptional, "axis that turns the needle and the bodies `on_turn`"),
    name_of("lift", &RolesRow::lift, kOptional, "axis that lowers the bodies `on_lift`"),
};

const Fields<ChannelRow> kChannel{
    name_of("station", &ChannelRow::station, kRequired, "one of `stations`"),
    integer("bit", &ChannelRow::bit, {0, 255}, kOptional, "bit of its process image; or `terminal`"),
    name_of("terminal", &ChannelRow::terminal, kOptional, "the same by the name that the station's profile gives it"),
    placed(flag("invert", &ChannelRow::invert, kOptional, "0 means on"), &ChannelRow::invert_location),
};

const Fields<RoundRow> kRound{
    number("diameter", &RoundRow::diameter, D::Length, kPositive, kRequired, "over all"),
    number("height", &RoundRow::height, D::Length, kPositive, kRequired, "over all"),
};
Fields<BodyRow> body_fields(bool head) {
  Fields<BodyRow> fields{
      point("box", &BodyRow::box, kPositive, kOptional, "full edges along X, Y, Z"),
      object("cylinder", &BodyRow::cylinder, kRound, kOptional, "upright"),
      object("capsule", &BodyRow::capsule, kRound, kOptional, "upright, with round ends"),
      point("centre", &BodyRow::centre, kLength, kRequired, head ? "in the head's frame" : "in the machine frame"),
      number("rotation", &BodyRow::rotation_rad, D::Angle, kHalfTurn, kOptional, "about Z"),
  };
  if (!head) return fields;
  fields.push_back(flag("on_lift", &BodyRow::on_lift, kOptional, "rides on the lift axis"));
  fields.push_back(placed(flag("on_turn", &BodyRow::on_turn, kOptional,
                               "turns with the axis `turn`, about the upright line through the needle's tip"),
                          &BodyRow::on_turn_location));
  return fields;
}
const Fields<BodyRow> kHeadBody = body_fields(true), kSceneBody = body_fields(false);

const Fields<ToolRow> kTool{
    point("tip", &ToolRow::tip, kLength, kRequired, "working point in the head's frame, lift at 0"),
    number("lift", &ToolRow::lift_mm, D::Length, {0, 1e4}, kOptional,
           "lift axis while the tool works; for bodies on it"),
};
const Fields<HeadRow> kHead{
    named("tools", &HeadRow::tools, kTool, {1, 16}, kRequired, "needle, camera, probe"),
    named("bodies", &HeadRow::bodies, kHeadBody, {1, 64}, kRequired, "what moves and must not hit anything"),
};

const Fields<FrameRow> kFrame{
    point("origin", &FrameRow::origin, kLength, kRequired, "in machine coordinates"),
};

const Fields<CameraConfig> kCamera{
    integer("width_px", &CameraConfig::width_px, {64, 10000}, kRequired, "pixels along X"),
    integer("height_px", &CameraConfig::height_px, {64, 10000}, kRequired, "pixels along Y"),
    number("pixel", &CameraConfig::mm_per_px, D::Length, {1e-4, 1}, kRequired, "edge of a pixel at the focus plane"),
    number("exposure", &CameraConfig::exposure_s, D::Time, {1e-6, 1}, kOptional, "time of exposure"),
    integer("expose_after_ticks", &CameraConfig::expose_after_ticks, {1, 10000}, kRequired,
            "bus cycles between arrival and trigger: the axes have settled"),
    number("answer_latency", &CameraConfig::answer_latency_s, D::Time, {0.001, 10}, kRequired,
           "an answer takes effect this long after the trigger, so that runs repeat"),
    number("search", &CameraConfig::search_mm, D::Length, {0.1, 1000}, kRequired,
           "half width of the window in which a mark is looked for"),
};

const Fields<ProbeRow> kProbe{
    name_of("axis", &ProbeRow::axis, kRequired, "axis whose drive latches"),
    number("speed", &ProbeRow::speed_mm_s, D::Speed, {0.1, 100}, kRequired,
           "towards the surface; presses in by what it travels in 25 ms, and the braking distance"),
    number("approach", &ProbeRow::approach_mm, D::Length, {0.1, 100}, kRequired, "begins this far above the surface"),
    number("travel", &ProbeRow::travel_mm, D::Length, {0.1, 100}, kRequired, "gives up after this distance"),
    number("retract", &ProbeRow::retract_mm, D::Length, {0.1, 100}, kRequired, "back up after the touch"),
    number("fast", &ProbeRow::fast_mm_s, D::Speed, {0.1, 100}, kOptional,
           "of a first touch that finds the surface; the one at `speed` follows and counts. The virtual probe bears 10 "
           "mm/s"),
    number("back_off", &ProbeRow::back_off_mm, D::Length, {0.1, 100}, kOptional,
           "up from the first touch before the second; else 1 mm"),
};

const Fields<BrakeRow> kBrake{
    name_of("axis", &BrakeRow::axis, kRequired, "what it holds; released while that axis has torque"),
    name_of("output", &BrakeRow::output, kRequired, "a free name of `outputs`; on: released"),
    number("time", &BrakeRow::time_s, D::Time, {0, 2}, kRequired, "until it holds, from the output that goes off"),
    number("release", &BrakeRow::release_s, D::Time, {0, 2}, kOptional,
           "until it is open, from the output that goes on: nothing moves before; else as long as `time`"),
};

const Fields<StallRow> kStall{
    integer("hardware", &StallRow::hardware, {1, 1000}, kRequired, "cycles"),
    integer("sim", &StallRow::sim, {1, 100000}, kRequired, "cycles"),
};
const Fields<BusRow> kBus{
    number("cycle", &BusRow::cycle_s, D::Time, {0.00025, 0.01}, kRequired, "SYNC0 cycle of every station"),
    {{"stop_after_missed", kRequired, "cycles in a row that may be missed", object_shape(kStall)},
     [](const Node& node, BusRow& to, Mistakes& mistakes) {
       read_object(node, kStall, to.stop_after_missed.value, node.location, mistakes);
       to.stop_after_missed.location = node.location;
     }},
    placed(
        integer("frames_lost_max", &BusRow::frames_lost_max, {1, 100}, kOptional, "frames in a row that may be lost"),
        &BusRow::frames_lost_location),
    choice("map", &BusRow::map, Choices<MapKind>{{"separate", MapKind::Separate}, {"overlapped", MapKind::Overlapped}},
           kOptional, "a station's inputs lie behind its outputs in the logical map, or over them (shorter frames)"),
};

const Fields<SimAxisRow> kSimAxis{
    number("lag", &SimAxisRow::lag_s, D::Time, {0, 0.1}, kRequired, "time constant of the position loop"),
    number("delay", &SimAxisRow::delay_s, D::Time, {0, 0.1}, kOptional, "pure delay before it"),
    quantity("coast", &SimAxisRow::coast, kAcceleration, kOptional,
             "what slows the axis down without torque; left out: it stops at once"),
    quantity("home_switch", &SimAxisRow::home_switch, kPosition, kOptional, "coordinate of its edge"),
    choice("home_active", &SimAxisRow::home_active_below, Choices<bool>{{"below", true}, {"above", false}}, kOptional,
           "side of the edge on which it is closed"),
    quantities("limits", &SimAxisRow::limits, 2, kPosition, kRequired, "coordinates of the limit switches"),
    quantity("start", &SimAxisRow::start, kPosition, kRequired, "where the axis stands when the world is new"),
};
const Fields<ValveRow> kValve{
    number("open_lag", &ValveRow::open_lag_s, D::Time, {0, 1}, kRequired, "from the output to flowing"),
    number("close_lag", &ValveRow::close_lag_s, D::Time, {0, 1}, kRequired, "from the output to closed"),
};
const Fields<SimBoardRow> kSimBoard{
    number("height_spread", &SimBoardRow::height_spread_mm, D::Length, {0, 10}, kRequired, "+- of its surface"),
    number("tilt_spread", &SimBoardRow::tilt_spread_rad, D::Angle, {0, units::rad(5)}, kRequired, "+- of its surface"),
    number("place_spread", &SimBoardRow::placement_spread_mm, D::Length, {0, 20}, kRequired, "+- of where it lies"),
    number("turn_spread", &SimBoardRow::placement_spread_rad, D::Angle, {0, units::rad(10)}, kRequired,
           "+- of how it is turned"),
};
const Fields<TipErrorRow> kTipErrors{
    point("needle", &TipErrorRow::needle, {-10, 10}, kOptional, "true minus configured tip"),
    point("camera", &TipErrorRow::camera, {-10, 10}, kOptional, "true minus configured tip"),
    point("probe", &TipErrorRow::probe, {-10, 10}, kOptional, "true minus configured tip"),
};
const Fields<SimRow> kSim{
    named("axes", &SimRow::axes, kSimAxis, {1, kMaxAxes}, kRequired, "one an axis"),
    object("valve", &SimRow::valve, kValve, kRequired, "how late the valve acts"),
    object("board", &SimRow::board, kSimBoard, kRequired, "how a seed places the board"),
    number("camera_noise", &SimRow::camera_noise, D::None, {0, 50}, kOptional, "grey levels, sigma"),
    object("tip_errors", &SimRow::tip_errors, kTipErrors, kOptional, "what calibration does not know"),
};

}  // namespace

const Fields<MachineFile>& machine_fields() {
  static const Fields<MachineFile> kFields{
      format_version<MachineFile>(1),
      name_of("machine", &MachineFile::name, kRequired, "its name"),
      object("bus", &MachineFile::bus, kBus, kRequired, "timing of the bus"),
      named("stations", &MachineFile::stations, kStation, {1, 256}, kRequired, "bus nodes"),
      named("axes", &MachineFile::axes, kAxis, {1, kMaxAxes}, kRequired, "in the order of their numbers"),
      object("roles", &MachineFile::roles, kRoles, kRequired, "which axis carries what"),
      named("outputs", &MachineFile::outputs, kChannel, {0, 256}, kRequired,
            "what the machine switches: names that the program knows, and free ones"),
      named("inputs", &MachineFile::inputs, kChannel, {0, 256}, kRequired,
            "what the machine reads: names that the program knows, and free ones"),
      object("head", &MachineFile::head, kHead, kRequired, "what X, Y and Z carry; its reference point is 0, 0, 0"),
      named("frames", &MachineFile::frames, kFrame, {1, 64}, kRequired, "where boards lie"),
      named("scene", &MachineFile::scene, kSceneBody, {0, 1000}, kRequired, "bodies that stand"),
      named("keep_out", &MachineFile::keep_out, kSceneBody, {0, 1000}, kOptional,
            "zones that nothing of the head enters; they are no matter"),
      placed(object("camera", &MachineFile::camera, kCamera, kRequired, "the camera on the head"),
             &MachineFile::camera_location),
      object("probe", &MachineFile::probe, kProbe, kRequired, "the touch probe"),
      object("brake", &MachineFile::brake, kBrake, kOptional,
             "a brake that the machine releases; those that a drive works are left to it"),
      number("clearance", &MachineFile::clearance_mm, D::Length, {0, 100}, kRequired, "kept from every body in travel"),
      number("safe_z", &MachineFile::safe_z_mm, D::Length, kLength, kRequired, "Z for travel that finds nothing lower"),
      number("hold_within", &MachineFile::hold_within_s, D::Time, {0, 3600}, kOptional,
             "a hold waits for the end of the feature if that is so near, and stops on it if not"),
      number("override_max", &MachineFile::override_max, D::Ratio, {1, 2}, kOptional,
             "the highest override, where the materials of a job do not allow more; the axes' own limits always hold"),
      named_quantities("park", &MachineFile::park, kPosition, kRequired, "where a job ends"),
      object("sim", &MachineFile::sim, kSim, kRequired, "truth of the simulated machine"),
  };
  return kFields;
}

}  // namespace written

const std::vector<FieldShape>& machine_format() {
  static const std::vector<FieldShape> kFormat = object_shape(written::machine_fields()).fields;
  return kFormat;
}

}  // namespace gantry::config
