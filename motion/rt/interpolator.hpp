// Plays segments from a ring, one tick (Limits::tick_s) a step: the tool is always on its path, every axis within its
// limits, and there is always a jerk-limited stop before the end of the path that is known.
//   Interpolator play(ring, limits, valve_bits);  play.start(q_now);  play.begin_block(7);
//   Setpoint p = play.step(override);             // every tick, also when idle
//   play.hold(); ... play.resume();               // effect from the next step on
// Nominal play evaluates s(t) of the segments as planned. Hold, override, starvation and their ends re-plan s alone.
// The consumer side of the ring is the interpolator's. Lives in the loop: no allocation, no lock.
#pragma once
#include <array>
#include <cstdint>
#include <limits>

#include "core/id.hpp"
#include "motion/profile/planner.hpp"
#include "motion/rt/lookahead.hpp"
#include "motion/rt/output_word.hpp"
#include "motion/types.hpp"

namespace gantry::motion {

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

  /// One tick on. override_factor: 0.1 .. 2.0, 1 = as planned; clamped.
  Setpoint step(double override_factor) noexcept;

  void hold() noexcept;       ///< brakes on the path; the valve closes at once
  void resume() noexcept;     ///< after hold or stop_path
  void stop_path() noexcept;  ///< like hold, for a fault
  void abort() noexcept;      ///< brakes on the path, then drops the rest of the block
  /// The probe has latched where `axis` stood at `position`: the block ends a fixed way beyond that place, whenever
  /// this is told; told too late for that, at once.
  void probe_latched(AxisId axis, double position) noexcept;
  void axis_stop() noexcept;  ///< every axis brakes with its own limits; the path is lost, the block is dropped

  /// Sets bits of the output word outside the valve's.
  void set_outputs(std::uint32_t mask, std::uint32_t bits) noexcept;

  [[nodiscard]] bool idle() const noexcept;      ///< no block plays
  [[nodiscard]] bool at_rest() const noexcept;   ///< the setpoint stands
  [[nodiscard]] bool held() const noexcept;      ///< hold or stop_path is in force
  [[nodiscard]] bool starving() const noexcept;  ///< slowed down because the block's next segments are not there

 private:
  enum class Doing : std::uint8_t { Nothing, Block, AxisStop };
  enum class Course : std::uint8_t {
    None,      ///< between segments: the next one is not entered yet
    Nominal,   ///< as the planner made it, a dwell too
    ToEnd,     ///< re-planned to the segment's end
    ToRest,    ///< braking to rest, over following segments too
    Standing,  ///< at rest within a segment
  };
  enum class AfterStop : std::uint8_t { Wait, Drop, EndBlock };

  // interpolator.cpp: time goes on
  bool advance() noexcept;
  bool enter() noexcept;
  bool leave() noexcept;
  void pop() noexcept;
  void pop_block(std::uint32_t block) noexcept;
  void drop_block() noexcept;
  bool stands() noexcept;
  void take_path_state() noexcept;
  Setpoint axis_stop_tick() noexcept;
  [[nodiscard]] Setpoint setpoint() const noexcept;
  // replan.cpp: what s does next
  void brake(AfterStop then) noexcept;
  void adopt(Course course, const Profile& profile) noexcept;
  void choose_course() noexcept;
  bool replan(const State& x) noexcept;
  bool replan_to_rest(const State& x) noexcept;
  bool replan_beyond(AxisId axis, double position) noexcept;
  bool speeds_fit(const Profile& braking, std::size_t segments) noexcept;
  [[nodiscard]] bool nominal_fits(const Segment& s, double v_in) const noexcept;
  double v_at_end() noexcept;
  bool can_brake(double t) noexcept;
  bool rest_is_known() noexcept;
  double v_allowed(std::size_t i) noexcept;
  void see_new_segments() noexcept;
  // fire.cpp: events
  void fire_events() noexcept;
  void take_back_events() noexcept;
  bool is_due(std::size_t segment, const OutputEvent& e) noexcept;

  const Segment& front() noexcept { return *ring_.peek(0); }
  std::uint8_t& fired(std::size_t i) noexcept { return fired_[(popped_ + i) % kEventWindow]; }

  static constexpr double kWholeWay = std::numeric_limits<double>::infinity();
  static constexpr std::size_t kEventWindow = 32;  ///< segments ahead in which events are looked for

  SegmentRing& ring_;
  Limits limits_;
  Lookahead ahead_;
  OutputWord outputs_;
  Segment scratch_;  ///< where popped segments go: too large for the stack

  Doing doing_ = Doing::Nothing;
  std::uint32_t block_ = 0, tick_in_block_ = 0;
  bool started_ = false;  ///< the block's first segment was entered
  bool stopping_ = false;
  AfterStop after_stop_ = AfterStop::Wait;
  double override_ = 1;

  Course course_ = Course::None;
  Profile profile_;             ///< s(t) on the front segment
  double t_ = 0, t_end_ = 0;    ///< into it, and its duration
  double way_end_ = kWholeWay;  ///< s at which a touch ends on the front segment
  double v_in_ = 0;             ///< path speed at which the next segment is entered
  double v_out_ = 0;            ///< path speed at which a course ToEnd comes to the end
  bool stale_ = false;          ///< the course has to be planned anew, as soon as it can be
  bool starving_ = false;
  bool looked_ahead_ = false;   ///< ahead_ is up to date
  std::size_t popped_ = 0;      ///< segments that have gone so far
  std::size_t seen_ = 0;        ///< segments that have come so far
  std::size_t scanned_ = 0;     ///< segments looked at for a rest
  std::size_t rest_after_ = 0;  ///< number, from 1, of the nearest segment known to rest at its end
  std::array<std::uint8_t, kEventWindow> fired_{};

  AxisVec q_{}, v_{}, a_{};
  double s_ = 0, s_dot_ = 0;
  std::uint32_t feature_ = kTravel;
  bool probing_ = false, moving_ = false;
  std::array<Profile, kMaxAxes> axis_stop_{};
  double axis_stop_t_ = 0;
};

}  // namespace gantry::motion
