// The machine file as it is written: locations kept, names not yet looked up, mm or degrees not yet decided.
// load.cpp makes a Machine of it, check.cpp judges what only shows across several rows.
#pragma once
#include "config/fields.hpp"
#include "config/machine.hpp"

namespace gantry::config::written {

/// A parameter of a station: one value for all of its axes, or one for each.
struct SettingRow {
  std::string name;
  Location location;
  std::vector<At<std::string>> values;
  bool unread = false;
};
struct InputsRow {
  int negative_limit = -1, positive_limit = -1, home = -1;
  Location location;
};
struct StationRow {
  std::string name;
  Location location;
  At<std::string> profile;
  At<int> position;
  int alias = 0;
  Location alias_location;
  std::vector<SettingRow> parameters;
  std::vector<At<std::string>> declared;
  std::optional<InputsRow> inputs;
  bool emergency_stop_elsewhere = false;
};

struct DriveRow {
  At<std::string> station;
  At<int> slot;
  bool invert = false;
  Location location;
};

struct HomingRow {
  int order = 0;
  At<int> method;
  At<Quantity> fast, slow, acceleration, position;
  double timeout_s = 60;
  At<Quantity> rack_max, square_max;
  bool limits_unseen = false;
  Location location;
};

struct FollowingRow {
  At<Quantity> base;
  double per_speed_s = 0;
};

struct AxisRow {
  std::string name;
  Location location;
  AxisKind kind = AxisKind::Streamed;
  std::vector<DriveRow> drives;
  At<Quantity> per_rev, v_max, a_max, j_max, skew_max;
  At<std::vector<Quantity>> travel;
  std::optional<FollowingRow> following;
  double response_delay_s = 0;
  Location response_delay_location;
  At<Quantity> path_error;
  bool self_locking = false;
  Location self_locking_location;
  std::optional<HomingRow> homing;
};

struct RolesRow {
  At<std::string> x, y, z, turn, lift;
};

struct ChannelRow {
  std::string name;
  Location location;
  At<std::string> station, terminal;
  At<int> bit;  ///< or `terminal`
  bool invert = false;
  Location invert_location;
  bool unread = false;  ///< something of it is a mistake
};

struct RoundRow {
  double diameter = 0, height = 0;
};
struct BodyRow {
  std::string name;
  Location location;
  std::optional<Vec3> box;
  std::optional<RoundRow> cylinder, capsule;
  Vec3 centre;
  double rotation_rad = 0;
  bool on_lift = false;
  bool on_turn = false;
  Location on_turn_location;
  bool unread = false;  ///< something of it is a mistake
};

struct ToolRow {
  std::string name;
  Location location;
  Vec3 tip;
  At<double> lift_mm;
};
struct HeadRow {
  std::vector<ToolRow> tools;
  std::vector<BodyRow> bodies;
};

struct FrameRow {
  std::string name;
  Location location;
  Vec3 origin;
};

struct ProbeRow {
  At<std::string> axis;
  double approach_mm = 0, retract_mm = 0;
  At<double> speed_mm_s, travel_mm, fast_mm_s, back_off_mm;
};

struct BrakeRow {
  At<std::string> axis, output;
  double time_s = 0;
  std::optional<double> release_s;
};

struct StallRow {
  int hardware = 3, sim = 50;
};
struct BusRow {
  At<double> cycle_s;
  At<StallRow> stop_after_missed;
  int frames_lost_max = 3;
  Location frames_lost_location;
  MapKind map = MapKind::Separate;
};

struct SimAxisRow {
  std::string name;
  Location location;
  double lag_s = 0, delay_s = 0;
  At<Quantity> coast, home_switch, start;
  bool home_active_below = true;
  At<std::vector<Quantity>> limits;
};
struct ValveRow {
  double open_lag_s = 0, close_lag_s = 0;
};
struct SimBoardRow {
  double height_spread_mm = 0, tilt_spread_rad = 0, placement_spread_mm = 0, placement_spread_rad = 0;
};
struct TipErrorRow {
  Vec3 needle, camera, probe;
};
struct SimRow {
  std::vector<SimAxisRow> axes;
  ValveRow valve;
  SimBoardRow board;
  TipErrorRow tip_errors;
  double camera_noise = 2.0;
};

struct MachineFile {
  std::string name;
  BusRow bus;
  std::vector<StationRow> stations;
  std::vector<AxisRow> axes;
  RolesRow roles;
  std::vector<ChannelRow> outputs, inputs;
  HeadRow head;
  std::vector<FrameRow> frames;
  std::vector<BodyRow> scene, keep_out;
  CameraConfig camera;
  Location camera_location;
  ProbeRow probe;
  std::optional<BrakeRow> brake;
  double clearance_mm = 2;
  double hold_within_s = 2;
  double override_max = 1;
  At<double> safe_z_mm;
  std::vector<NamedQuantity> park;
  SimRow sim;
};

const Fields<MachineFile>& machine_fields();

}  // namespace gantry::config::written

namespace gantry::config {

/// `outputs` and `inputs`, once the stations are there: known names and free ones, bits and terminals, each bit once.
void resolve_channels(const written::MachineFile& file, Machine& machine, Mistakes& mistakes);

/// The start-up rows of a station: its profile's parameters, with what the machine file states instead.
void resolve_parameters(const written::StationRow& row, Station& station, Mistakes& mistakes);

/// Sentences for `check` about wiring that is allowed and unwise.
std::vector<std::string> channel_notes(const Machine& machine);

/// What a drive holds of its own limits against what its axis is asked for: mistakes, and sentences for `check`.
void check_drive_limits(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
std::vector<std::string> drive_limit_notes(const Machine& machine);

/// "12.5 mm", "90 deg/s": a value of an axis as people write it.
/// From rest to v_max takes so long that v_max, a_max or j_max is a slip of the unit.
bool starts_too_slowly(const Axis& axis);
std::string in_units(const Axis& axis, double value, std::string_view per = "", int digits = 6);
/// "outside the travel of axis Z, -80 mm .. 0 mm"
std::string outside_of(const Axis& axis);

/// Whether homing can be right: each axis that gets targets has one, up and towards a switch that stands where it is
/// said to, no faster than the axis.
/// How far a fault of one side at v_max may leave the sides of a gantry axis apart: until it is seen, and while the
/// other side brakes, with limited jerk. Homing leads out of it. In the axis' units.
double racked_by_fault(const Axis& axis);
void check_homing(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
std::vector<std::string> homing_notes(const Machine& machine);

/// What the cycle of the bus asks of stations and axes, and whether the windows that watch an axis can hold, and can
/// bite.
bool check_timing(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
void check_windows(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
std::vector<std::string> window_notes(const Machine& machine);

/// Whether the bodies of the head end where its tools work, and what is asked of probe and camera.
void check_head(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
std::vector<std::string> head_notes(const Machine& machine);

/// What is stated of a station against what the program counts on.
void check_parameters(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);
std::vector<std::string> parameter_notes(const Machine& machine);

/// What only shows across rows: a station's slot used twice, limits that exclude each other, a park position out of
/// reach ... `file` is where `machine` was made from, row by row.
void check_machine(const Machine& machine, const written::MachineFile& file, Mistakes& mistakes);

}  // namespace gantry::config
