// The machine as its YAML file tells it, after units are converted and names are resolved. Plain structs, no behaviour.
//   auto m = config::load_machine("config/machines/dispenser.yaml");   // Checked<Machine>: every mistake at once
// Coordinates: machine frame in mm, Z up. A point p of the head stands at p + (X, Y, Z), lower by U when its body rides
// on the lift; of a body that turns with C it is turned about the upright line through the needle's tip before that.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/drive.hpp"
#include "core/clock.hpp"
#include "core/error.hpp"
#include "core/id.hpp"
#include "core/vec.hpp"

namespace gantry::config {

/// A drive of an axis: which station, and which of the station's axes.
struct DriveRef {
  StationId station;
  int slot = 0;
  bool invert = false;  ///< counts rise while the axis coordinate falls
};

enum class AxisKind {
  Streamed,    ///< gets a target every cycle (CSP)
  Positioned,  ///< moves by itself to a target (PP); never part of a coordinated move
};

struct Homing {
  int order = 0;               ///< axes of the lowest order go first (Z), equal ones together
  std::int8_t method = 0;      ///< 6098h
  bool limits_unseen = false;  ///< the file accepts that nothing but the drive watches the limits of this axis
  double fast = 0, slow = 0;   ///< mm/s or rad/s: 6099h:1, :2
  double acceleration = 0;     ///< mm/s^2 or rad/s^2: 609Ah
  double position = 0;         ///< axis coordinate at the home edge, mm or rad
  double timeout_s = 60;
  double rack_max = 0;    ///< gantry axis: how much farther one side may go than the other while both search, mm
  double square_max = 0;  ///< gantry axis: difference of its sides at their switches that homing removes, mm
};

/// What `gantry commission AXIS` has found of response_delay, and when.
struct MeasuredDelay {
  double delay_s = 0;
  double within_s = 0;  ///< what the measurement itself leaves open
  double speed = 0;     ///< mm/s or rad/s
  std::string date;     ///< "2026-11-22"
};

struct Axis {
  AxisId id;
  std::string name;  ///< "X"
  AxisKind kind = AxisKind::Streamed;
  bool rotary = false;           ///< rad instead of mm
  std::vector<DriveRef> drives;  ///< two of one coordinate: a gantry axis
  double unit_per_rev = 0;       ///< mm or rad of travel in one motor revolution
  double counts_per_unit = 0;    ///< counts per mm or rad: profile's counts_per_rev / unit_per_rev
  double p_min = 0, p_max = 0, v_max = 0, a_max = 0, j_max = 0;  ///< soft limits and bounds, mm or rad
  double following_base = 0;  ///< following window = base + per_speed * |v|; mm or rad
  double following_per_speed_s = 0;
  double skew_max = 0;  ///< gantry axis: allowed difference of its two sides
  double response_delay_s =
      0;  ///< how far the axis lags its command; compensated so that unlike drives do not bend the path
  /// Besides what the path itself may deviate: how far the axis may be off its path in motion, mm or rad. Kept from
  /// bodies over and above the clearance.
  double path_error = 0;
  bool self_locking = false;  ///< without torque nothing moves it: what an open-loop drive cannot see
  std::optional<Homing> homing;
  std::optional<MeasuredDelay> measured;  ///< of the machine's state, not of its file
};

/// One bit of a station's process image.
struct Channel {
  StationId station;
  std::uint8_t bit = 0;
  bool invert = false;
};
/// An output or input that the program gives no meaning to; it goes by the name in the machine file.
struct FreeChannel {
  std::string name;
  Channel channel;
};

enum class Output : std::uint8_t {
  Valve,
  CameraLight,
  CameraTrigger,
  StackRed,
  StackYellow,
  StackGreen,
  Clamp,
  Healthy,
  Count
};
/// Stop, DoorClosed, AirOk and SafetyOk are normally closed: 1 says that all is well, and a broken wire reads as 0.
enum class Input : std::uint8_t {
  Start,
  Stop,  ///< 0: pressed
  Reset,
  Hold,
  Mode,  ///< 1: automatic, 0: setup; a machine without it is always automatic
  DoorClosed,
  AirOk,
  ClampClosed,
  SafetyOk,  ///< feedback of the external safety chain
  Count
};
inline constexpr std::size_t kOutputs = static_cast<std::size_t>(Output::Count);
inline constexpr std::size_t kInputs = static_cast<std::size_t>(Input::Count);
/// Name in the machine file: "valve", "camera_light", ...
std::string_view name(Output output);
std::string_view name(Input input);
/// Bit of an output in the loop's output word.
constexpr std::uint32_t bit(Output o) { return 1u << static_cast<unsigned>(o); }
constexpr std::uint32_t bit(Input i) { return 1u << static_cast<unsigned>(i); }
inline constexpr std::size_t kChannelBits = 32;  ///< of the loop's output word, and of its input word
bool normally_closed(Input input);

/// What a station's firmware says it is (1018h:1, 1018h:2); 0: it does not say.
struct ObjectIdentity {
  std::uint32_t vendor = 0, product = 0;
  bool operator==(const ObjectIdentity&) const = default;
};

/// What `gantry commission --accept`, or a walk, has found at a station's place, and when.
struct Accepted {
  std::uint32_t vendor = 0, product = 0, revision = 0, serial = 0;
  std::string date;         ///< "2026-11-22"
  bool compared = false;    ///< a person has said by `--accept` that it belongs there; a walk keeps only what it found
  std::string walked{};     ///< when a person has seen its axes move; empty: nobody has
  std::string walked_as{};  ///< what the machine file said of them then: config::wiring_of()
  ObjectIdentity object{};  ///< what 1018h said when it was accepted; 0: nothing is known of that
};

struct Station {
  StationId id;
  std::string name;  ///< "y1"
  BusKind bus = BusKind::EtherCat;
  int position = 0;         ///< place in the ring, 0 first; node id on CANopen
  std::uint16_t alias = 0;  ///< 0: not checked
  StationProfile profile;
  bool emergency_stop_elsewhere = false;  ///< the file says so of a drive whose emergency stop input is given away
  std::optional<Accepted> accepted;       ///< of the machine's state, not of its file
  bool restart_pending = false;           ///< of its state, too: it may hold values that act at its next power-up
  /// Its process data stand in the image that the loop exchanges each cycle.
  [[nodiscard]] bool cyclic() const { return bus == BusKind::EtherCat; }
};

/// A convex body. Centre and extents in mm; cylinders and capsules stand along Z.
struct Shape {
  enum class Kind { Box, Cylinder, Capsule } kind = Kind::Box;
  Vec3 size;  ///< box: full edges; cylinder: {diameter, diameter, height}; capsule: the same, height over all
};
struct Body {
  std::string name;
  Shape shape;
  Vec3 centre;              ///< in the head's frame (of the head) or the machine frame (of the scene)
  double rotation_rad = 0;  ///< about Z
  bool on_lift = false;     ///< head only: rides on U
  bool on_turn = false;     ///< head only: turns with C, about turn_axis()
  bool keep_out = false;    ///< no matter, but a zone that nothing of the head enters
};

/// What may be brought to a point: needle, camera, probe. `tip` is its working point in the head's frame at U = 0 (for
/// the camera the point in focus).
struct Tool {
  std::string name;
  Vec3 tip;
  double lift_mm = 0;  ///< U while the tool works; others keep U = 0
};

struct CameraConfig {
  int width_px = 0, height_px = 0;
  double mm_per_px = 0;  ///< at the focus plane
  double exposure_s = 0.002;
  int expose_after_ticks = 40;     ///< ticks between arrival and trigger: the axes have settled
  double answer_latency_s = 0.15;  ///< an answer takes effect this long after the trigger, so that runs repeat
  double search_mm = 0;            ///< half width of the window in which a mark is looked for
};

struct ProbeConfig {
  AxisId axis;  ///< Z, whose drive latches
  double speed_mm_s = 0, approach_mm = 0, travel_mm = 0, retract_mm = 0;
  double fast_mm_s = 0;    ///< of a first touch that finds the surface; 0: there is none
  double back_off_mm = 0;  ///< up from it, before the touch that counts
};

/// A brake that the machine itself releases, by a free output (1: released); those of the drives go by themselves.
struct BrakeConfig {
  AxisId axis;
  unsigned bit = 0;      ///< in the loop's output word
  double time_s = 0;     ///< from the output that goes off to a brake that holds
  double release_s = 0;  ///< from the output that goes on to a brake that is open
};

/// Where boards lie: the origin of the pallet's frame in machine coordinates.
struct WorkFrame {
  std::string name;
  Vec3 origin;
};

/// How stations share the logical map of the process data. Each has a region, one behind the other. Separate: its
/// outputs, then its inputs. Overlapped: both from the same address on (an LRW takes the outputs and leaves the inputs
/// in their place), which makes frames shorter.
enum class MapKind : std::uint8_t { Separate, Overlapped };

/// What bus timing tolerates, and how process data lies on it.
struct BusConfig {
  Time cycle = milliseconds(1);
  int stop_after_missed_hardware = 3;
  int stop_after_missed_sim = 50;
  int frames_lost_max = 3;  ///< consecutive (R02)
  MapKind map = MapKind::Separate;
};

/// Truth of the simulated machine, unknown to the controller.
struct SimAxis {
  double lag_s = 0;                     ///< time constant of the drive's position loop
  double delay_s = 0;                   ///< pure delay before it
  double coast = 0;                     ///< mm or rad/s^2 by which it slows down without torque; 0: it stops at once
  double home_switch = 0;               ///< axis coordinate of the home switch edge
  bool home_active_below = true;        ///< the home switch is closed at and below its edge; false: at and above
  double neg_limit = 0, pos_limit = 0;  ///< coordinates of the limit switches
  double start = 0;                     ///< where the axis stands when the world is new
};
struct SimConfig {
  std::vector<SimAxis> axes;  ///< by AxisId
  double valve_open_lag_s = 0, valve_close_lag_s = 0;
  double height_spread_mm = 0;  ///< seed places the board's surface within +- this
  double tilt_spread_rad = 0;
  double placement_spread_mm = 0, placement_spread_rad = 0;  ///< of the seeded placement
  double camera_noise = 2.0;                                 ///< grey levels, sigma
  Vec3 needle_error, camera_error, probe_error;              ///< true minus configured tip offsets
};

/// What the virtual probe bears at contact; of a real one its data sheet tells.
inline constexpr double kVirtualProbeBears_mm_s = 10;

struct Machine {
  std::string name;
  std::string file;    ///< path it was read from
  std::string sha256;  ///< of the bytes that were read
  BusConfig bus;
  std::vector<Station> stations;
  std::vector<Axis> axes;      ///< index = AxisId
  AxisId x, y, z;              ///< the carrying axes
  std::optional<AxisId> c, u;  ///< needle turn and lift
  std::array<std::optional<Channel>, kOutputs> outputs;
  std::array<std::optional<Channel>, kInputs> inputs;
  std::vector<FreeChannel> free_outputs, free_inputs;
  std::vector<Tool> tools;     ///< "needle", "camera", "probe"
  std::vector<Body> head;      ///< bodies that move
  std::vector<Body> scene;     ///< bodies that stand
  std::vector<Body> keep_out;  ///< zones that nothing of the head enters, named by zone_name()
  std::vector<WorkFrame> frames;
  CameraConfig camera;
  ProbeConfig probe;
  std::optional<BrakeConfig> brake;
  double clearance_mm = 2.0;  ///< kept from every body in travel, over and above path deviation
  double safe_z_mm = 0;       ///< Z for parking and for travel that finds nothing shorter
  double hold_within_s = 2;   ///< a hold waits for the end of the feature if that is so near
  double override_max = 1;    ///< the highest override, unless a job's materials allow more; 1: the recipe's speed
  std::vector<std::pair<AxisId, double>> park;  ///< where a job ends
  SimConfig sim;
};

/// A channel that the machine has, and its bit in the loop's word. The bits of free channels follow those that are
/// known, in the order of the file.
struct WordBit {
  unsigned bit = 0;
  std::string_view name;  ///< of the machine
  Channel channel;
};
std::vector<WordBit> output_bits(const Machine& machine);
std::vector<WordBit> input_bits(const Machine& machine);

/// "keep-out NAME": what messages call a zone. No body has such a name, for names have no blank.
std::string zone_name(std::string_view name);

const Tool* find_tool(const Machine& machine, std::string_view name);
const Axis* find_axis(const Machine& machine, std::string_view name);
const WorkFrame* find_frame(const Machine& machine, std::string_view name);
/// Where the upright line stands about which C turns, in the head's frame: it goes through the needle's tip, which
/// therefore stays where it is.
Vec2 turn_axis(const Machine& machine);

/// Reads a machine file and the profiles it names (profiles are looked for in `../drives` and `../devices` beside it).
/// Every mistake with its location; Fault 4xx.
Checked<Machine> load_machine(const std::string& path);

/// What the machine file must state before its machine may move on a bus of steel, as sentences with the remedy: the
/// current of each motor, where the emergency stop of a drive is whose input the probe takes, which bits of 60FDh are
/// the limits of an axis that homes. A simulated machine is warned of it.
std::vector<std::string> wanted_on_steel(const Machine& machine);
inline constexpr std::string_view kOnSteel = ": refused on a bus of steel";

/// A brake holds the axis without torque at this drive: one of the drive's, or the machine's own.
bool is_braked(const Machine& machine, const Axis& axis, const DriveRef& drive);

/// Sentences for `check`: what the stations' profiles assume, and what else one should know (open-loop axes, what the
/// loss of the bus costs).
std::vector<std::string> assumptions(const Machine& machine);
std::vector<std::string> notes(const Machine& machine);

}  // namespace gantry::config
