// How far a job has come, as a value: what has been measured, which block is next, what became of each feature. One
// pure function says what comes next, and one does it step by step; the proof before motion, the runner and the report
// share them.
//   JobState state = begin_state(recipe, job);
//   auto ended = step_through(job, state, [&](const auto& step) -> Result<JobState> { ... return after_block(state);
//   });
// A copy of a state goes on with the next block exactly as the state itself does. How far the block is that plays
// stands in the runner, which alone sees it.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"
#include "recipes/job.hpp"

namespace gantry::job {

struct FoundMark {
  std::size_t mark = 0;  ///< index in Recipe::marks
  Vec2 at_mm;            ///< where it was found, in the frame of the nominal placement
  bool operator==(const FoundMark&) const = default;
};
struct TouchedHeight {
  std::size_t touch = 0;  ///< index in Recipe::touches
  double height_mm = 0;   ///< surface over its nominal height
  bool operator==(const TouchedHeight&) const = default;
};

/// What the job has measured so far.
struct Knowledge {
  std::vector<FoundMark> marks;        ///< in the order in which they were found
  std::vector<TouchedHeight> heights;  ///< in the order in which they were touched
  recipes::WorkOffset guess;           ///< where the board is likely to lie: the camera looks for the next mark there
  std::optional<recipes::WorkOffset> offset;  ///< once it is settled
  std::optional<recipes::Surface> surface;    ///< once it is settled
  bool operator==(const Knowledge&) const = default;
};

enum class FeatureState : std::uint8_t {
  Open,         ///< nothing of it is dispensed
  Begun,        ///< the valve is open for it
  Done,         ///< the valve has opened and closed for it as planned
  Interrupted,  ///< a stop has closed the valve on it, or kept it shut
  Doubtful,     ///< the valve was open for it when the job was lost sight of
  LeftOut,      ///< this job does not dispense it
};

/// Of a bead that a stop has cut: so much of it lies, along its motion.
struct LaidPart {
  std::size_t feature = 0;  ///< index in Recipe::features
  double mm = 0;
  double stood_s = 0;    ///< of its `start_dwell`, where it was cut in that
  double slow_mm_s = 0;  ///< what is left is laid at this speed, which is below its own; 0: at its own
  bool operator==(const LaidPart&) const = default;
};

struct JobState {
  Knowledge known;
  std::size_t block = 0;               ///< the next one: index in Job::blocks
  bool pressing = false;               ///< the probe has touched and was not lifted yet
  std::vector<FeatureState> features;  ///< by index in Recipe::features
  std::vector<LaidPart> laid;          ///< of beads that are joined where they were cut
  bool operator==(const JobState&) const = default;
};

// ---- what comes next ----

/// All marks were looked at: the work offset is worked out.
struct SettleOffset {
  bool operator==(const SettleOffset&) const = default;
};
/// All heights were touched: the surface is worked out.
struct SettleSurface {
  bool operator==(const SettleSurface&) const = default;
};
/// Straight up from the touch that was last.
struct Retract {
  std::size_t touch = 0;
  bool operator==(const Retract&) const = default;
};
struct Ended {
  bool operator==(const Ended&) const = default;
};
using Next = std::variant<SettleOffset, SettleSurface, recipes::LookAtMark, recipes::Touch, Retract,
                          recipes::PurgeNeedle, recipes::Dispense, recipes::Park, Ended>;

/// Pure. Of a block of features, those that are still open.
Next next(const recipes::Job& job, const JobState& state);

/// Of a feature that is open: what of it lies already.
LaidPart laid_of(const std::vector<LaidPart>& laid, std::size_t feature);

// ---- what becomes of the state ----

/// Nothing is known, nothing is done. What no block dispenses is left out.
JobState begin_state(const recipes::Recipe& recipe, const recipes::Job& job);
/// `at_mm` in the frame of the nominal placement. The guess follows: the first mark gives the shift, two give the
/// rotation as well.
JobState after_mark(const recipes::Recipe& recipe, JobState state, std::size_t mark, Vec2 at_mm);
JobState after_offset(JobState state, const recipes::WorkOffset& offset);
JobState after_touch(JobState state, std::size_t touch, double height_mm);
JobState after_retract(JobState state);
JobState after_surface(JobState state, const recipes::Surface& surface);
/// The block is over: its features are dispensed, the needle is purged or need not be, the head is parked. What became
/// of features is FeatureWatch's to say (feature_watch.hpp).
JobState after_block(JobState state);
/// A bead was cut, and is open again from there on.
JobState after_cut(JobState state, const LaidPart& part);
/// Nobody watches the valve any more: what was begun is doubtful.
JobState lost_sight(JobState state);

std::size_t count(const JobState& state, FeatureState what);

/// Lets `hand` do what comes next, step by step, until the job has ended or a step fails. `hand` is called with one of
/// the alternatives of Next (never Ended) and gives the state after it.
/// Within a step the hand may write into `state` what becomes of features meanwhile.
template <class Hand>
Result<void> step_through(const recipes::Job& job, JobState& state, Hand&& hand) {
  for (;;) {
    const Next step = next(job, state);
    if (std::holds_alternative<Ended>(step)) return {};
    auto after = std::visit(
        [&](const auto& what) -> Result<JobState> {
          if constexpr (std::is_same_v<std::decay_t<decltype(what)>, Ended>)
            return state;
          else
            return hand(what);
        },
        step);
    if (!after) return tl::unexpected(after.error());
    state = *std::move(after);
  }
}

}  // namespace gantry::job
