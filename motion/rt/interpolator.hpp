// Plays segments from a ring, one tick (Limits::tick_s) a step: the tool is always on its path, every axis within its
// limits, and there is always a jerk-limited stop before the end of the path that is known.
//   Interpolator play(ring, limits, valve_bits);  play.start(q_now);  play.begin_block(7);
//   Setpoint p = play.step(override);             // every tick, also when idle
//   play.hold(); ... play.resume();               // effect from the next step on
// Nominal play evaluates s(t) of the segments as planned. On a straight line hold and override re-plan s; on the pieces
// of a longer path they change the rate at which its planned time is played, and a stop whose whole path is straight
// re-plans s there, too.
// The consumer side of the ring is the interpolator's. Lives in the loop: no allocation, no lock.
#pragma once
#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "core/id.hpp"
#include "motion/profile/planner.hpp"
#include "motion/rt/output_word.hpp"
#include "motion/rt/piece_cursor.hpp"
#include "motion/rt/rate_change.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

inline constexpr double kLeastOverride = 0.01, kMostOverride = 2;

class Interpolator {
 public:
  /// valve_mask: bits of the output word that every hold and stop clears, and that only an OutputEvent with `dispense`
  /// sets again afterwards.
  Interpolator(SegmentRing& ring, const Limits& limits, std::uint32_t valve_mask) noexcept;

  /// Stands at q. Drops the block that plays, if any. Outputs stay, the valve is closed.
  void start(const AxisVec& q) noexcept;

  /// Plays the segments of `block`, from the next step on; segments of other blocks that are still in front are
  /// dropped. Only when idle.
  void begin_block(std::uint32_t block) noexcept;

  /// Drops the segments of a block that was not let begin, so that none is left for the next block of that number.
  void forget(std::uint32_t block) noexcept;

  /// One tick on. override_factor: kLeastOverride .. kMostOverride, 1 = as planned; clamped. Pieces of a longer path
  /// are never faster than planned. A change waits while the lead of a command goes by.
  Setpoint step(double override_factor) noexcept;

  void hold() noexcept;    ///< brakes on the path; the valve closes at once
  void resume() noexcept;  ///< after hold; comes to rest first
  void abort() noexcept;   ///< brakes on the path, then drops the rest of the block
  /// The probe has latched where `axis` stood at `position`: the block ends a fixed distance beyond that place,
  /// whenever this is told; told too late for that, at once.
  void probe_latched(AxisId axis, double position) noexcept;
  void axis_stop() noexcept;  ///< every axis brakes with its own limits; the path is lost, the block is dropped
  /// The same from another state than that of the plan, without acceleration.
  void axis_stop_from(const AxisVec& q, const AxisVec& v) noexcept;

  [[nodiscard]] bool idle() const noexcept;     ///< no block plays
  [[nodiscard]] bool at_rest() const noexcept;  ///< the setpoint stands
  [[nodiscard]] bool held() const noexcept;     ///< a hold is in force
  /// The valve was told to shut ahead of a place that the tool goes to still, and is not shut yet by its lead.
  [[nodiscard]] bool lays_its_last() const noexcept;
  [[nodiscard]] bool starving()
      const noexcept;  ///< waits or slows down because the block's next segments are not there

 private:
  enum class Doing : std::uint8_t { Nothing, Block, AxisStop };
  enum class Course : std::uint8_t {
    None,      ///< at rest between segments: the next one is not entered yet
    Nominal,   ///< a line as the planner made it, a dwell too
    ToEnd,     ///< re-planned to the line's end
    ToRest,    ///< braking to rest on a straight path, over following pieces too
    Standing,  ///< at rest within a line
    Paced,     ///< pieces of a path by their planned time, at a rate; at rest there, too
  };
  enum class AfterStop : std::uint8_t { Wait, Drop, EndBlock };

  // interpolator.cpp: time goes on
  Setpoint tick(double override_factor) noexcept;
  bool advance() noexcept;
  bool enter() noexcept;
  bool leave() noexcept;
  void pass_front() noexcept;
  void brake_on(double left) noexcept;
  void pop() noexcept;
  void pop_block(std::uint32_t block) noexcept;
  void drop_block() noexcept;
  bool stands() noexcept;
  bool take_path_state() noexcept;
  void brake_axes() noexcept;
  Setpoint axis_stop_tick() noexcept;
  [[nodiscard]] Setpoint setpoint() const noexcept;
  // replan.cpp: what s does next on a line
  void brake(AfterStop then) noexcept;
  void adopt(Course course, const Profile& profile) noexcept;
  void choose_course() noexcept;
  void stand_still() noexcept;
  bool replan(const State& x) noexcept;
  bool replan_beyond(AxisId axis, double position) noexcept;
  [[nodiscard]] Bounds bounds_of(const Segment& s) const noexcept;
  // pace.cpp: the rate at which pieces are played
  void choose_rate() noexcept;
  bool brake_on_line(const State& x) noexcept;
  bool pace(double& left) noexcept;
  void stand_on_piece() noexcept;
  bool enough_is_known() noexcept;
  bool rest_is_known() noexcept;
  void see_new_segments() noexcept;
  // fire.cpp: events
  void fire_events() noexcept;
  void fire_front() noexcept;
  void list_events() noexcept;
  void unlist_front() noexcept;
  void take_back_events() noexcept;
  [[nodiscard]] bool has_come_to(std::size_t number, double at_s) const noexcept;
  template <class Look>
  void each_waiting(Look&& look) noexcept;
  bool is_due(std::size_t segment, const OutputEvent& e) noexcept;
  [[nodiscard]] double lasts(const Segment& s, double seconds) const noexcept;
  bool comes_within(double ahead, std::size_t segment, double at_s) noexcept;
  double least_s(double rate, std::size_t segment, double at_s) noexcept;
  bool leaves_leads(double rate) noexcept;
  void set_out() noexcept;
  void open_first() noexcept;
  bool comes_to(std::size_t from, double ahead, std::size_t segment, double at_s) noexcept;

  const Segment& front() noexcept { return *ring_.peek(0); }

  /// Durations are sums of doubles: what ends within this of a tick ends on it. The shift stays below what jerk shows.
  static constexpr double kSnap_s = 1e-11;
  static constexpr double kBeyond = 1e-6;  ///< of s: rounding is far below, what any axis would show is above
  static constexpr double kWholeSegment = std::numeric_limits<double>::infinity();  ///< no probe touch ends it earlier

  SegmentRing& ring_;
  Limits limits_;
  OutputWord outputs_;
  Segment scratch_;  ///< where popped segments go: too large for the stack

  Doing doing_ = Doing::Nothing;
  std::uint32_t block_ = 0, tick_in_block_ = 0;
  bool started_ = false;  ///< the block's first segment was entered
  bool stopping_ = false;
  bool resumed_ = false;   ///< goes on from a standstill, or has found its path again: has not set out yet
  std::size_t leads_ = 0;  ///< ticks that it still stands, so that a valve's lead is whole
  AfterStop after_stop_ = AfterStop::Wait;
  double override_ = 1;

  Course course_ = Course::None;
  Profile profile_;                      ///< s(t) on the front segment; when paced, the segment's own counts
  double t_ = 0, t_end_ = 0;             ///< into it, and its duration
  double touch_end_mm_ = kWholeSegment;  ///< s at which a probe touch ends on the front segment
  bool stale_ = false;                   ///< the course on a line has to be planned anew, as soon as it can be
  Rate rate_;
  RateChange change_;
  double goal_ = 1;    ///< the rate that is, or that the change under way leads to
  double wanted_ = 1;  ///< the rate that is tried for
  unsigned tries_ = 0;
  Recent recent_{};
  bool starving_ = false;
  bool lost_ = false;           ///< s has left its piece, or the path has ended in motion
  std::size_t popped_ = 0;      ///< segments that have gone so far
  std::size_t seen_ = 0;        ///< segments that have come so far
  std::size_t scanned_ = 0;     ///< segments looked at for a rest
  std::size_t rest_after_ = 0;  ///< number, from 1, of the nearest segment known to rest at its end
  double known_s_ = 0;          ///< planned duration of the segments that were looked at, from the front one on
  double fastest_ = 0;          ///< mean speed of the fastest of them
  /// A segment with events, by its number, and which of them have fired.
  struct Waiting {
    std::size_t number = 0;
    std::uint8_t fired = 0;
  };
  std::array<Waiting, 16> waiting_{};  ///< the next ones
  std::size_t waiting_size_ = 0;
  std::size_t listed_ = 0;  ///< segments that were looked at for events
  struct Place {
    std::size_t number = 0;  ///< of its segment
    double at_s = 0;
    std::uint32_t until = 0;  ///< tick in the block
  };
  std::optional<Place> shuts_at_{};  ///< for which the valve was told to shut last

  AxisVec q_{}, v_{}, a_{};
  double s_ = 0, s_dot_ = 0;
  double gone_mm_ = 0;         ///< length of the block's segments that have been played
  double along_block_mm_ = 0;  ///< the same up to where the tool is
  std::uint32_t feature_ = kTravel;
  bool probing_ = false, moving_ = false;
  std::array<Profile, kMaxAxes> axis_stop_{};
  double axis_stop_t_ = 0;
};

}  // namespace gantry::motion
