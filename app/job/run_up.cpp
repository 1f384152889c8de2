#include "app/job/run_up.hpp"

#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr int kSteps = 16;       // of the entry speed, between `min_speed` and the bead's own
constexpr double kEntry = 0.98;  // of the entry speed, at which a bead that was cut has to be joined
constexpr double kBeforeJoin_mm[] = {0.25, 0.5, 1, 2,
                                     4};  // along what lies, where no path leads down to the very place

/// One way to begin it.
class Beginnings {
 public:
  Beginnings(const motion::Limits& limits, const motion::BeadSpec& spec, const IsFree& is_free)
      : limits_(limits), spec_(spec), is_free_(is_free) {}

  /// The error is that of the one to the bead's first point, or to where it was cut.
  Result<BegunBead> whole() const {
    auto out = attempt(spec_, RunUp::Kind::Whole);
    for (const double back_mm : kBeforeJoin_mm) {
      if (out || out.error().fault == Fault::Aborted || spec_.begin_mm <= back_mm) break;
      motion::BeadSpec spec = spec_;
      spec.begin_mm -= back_mm, spec.dry_mm = back_mm;
      auto sooner = attempt(spec, RunUp::Kind::Whole);
      if (sooner || sooner.error().fault == Fault::Aborted) return sooner;
    }
    return out;
  }
  Result<BegunBead> slower(double entry_mm_s) const {
    motion::BeadSpec spec = spec_;
    spec.entry_mm_s = entry_mm_s;
    return attempt(spec, entry_mm_s > 0 ? RunUp::Kind::Shorter : RunUp::Kind::FromRest);
  }
  Result<BegunBead> from_above(double fall_mm) const {
    motion::BeadSpec spec = spec_;
    spec.fall_mm = fall_mm;
    return attempt(spec, RunUp::Kind::FromAbove);
  }

 private:
  [[nodiscard]] bool joins() const { return spec_.begin_mm > 0; }
  Result<BegunBead> attempt(const motion::BeadSpec& spec, RunUp::Kind kind) const {
    auto planned = motion::plan_bead(limits_, spec);
    if (!planned) return tl::unexpected(planned.error());
    BegunBead out{*std::move(planned), {.kind = kind}};
    out.how.mm = out.motion.run_up_mm, out.how.joins = joins();
    for (std::size_t k = out.motion.bead_begin; k < out.motion.bead_end; ++k)
      if (const motion::Segment& s = out.motion.segments[k]; s.kind == motion::SegmentKind::Piece) {
        out.how.entry_mm_s = s.nominal.v0;
        break;
      }
    if (kind == RunUp::Kind::Shorter && joins() && out.how.entry_mm_s < kEntry * spec.entry_mm_s)
      return fail(Fault::SpeedNotReachable, "the bead is not come to at that speed");
    if (auto free = is_free_(out.motion, kind); !free) {
      Error e = free.error();
      if (e.fault != Fault::Aborted && out.motion.run_up_mm > 0)
        e.message = fmt::format("its run-up of {:.3g} mm: {}", out.motion.run_up_mm, e.message);
      return tl::unexpected(std::move(e));
    }
    return out;
  }

  const motion::Limits& limits_;
  const motion::BeadSpec& spec_;
  const IsFree& is_free_;
};

/// What another run-up may be the answer to. Within the axes' limits there is none to some places of a bend.
bool is_blocked(const Error& e, bool joins) {
  return e.fault == Fault::Collision || e.fault == Fault::SpeedNotReachable || (joins && e.fault == Fault::NoSolution);
}

/// By halves: the highest step that is free, where the lowest is.
Result<BegunBead> fastest_free(const Beginnings& bead, const motion::BeadSpec& spec, double least_mm_s) {
  Result<BegunBead> best = bead.slower(least_mm_s);
  for (int free = 0, blocked = kSteps; best && blocked - free > 1;) {
    const int middle = (free + blocked) / 2;
    auto tried = bead.slower(least_mm_s + (spec.speed_mm_s - least_mm_s) * middle / kSteps);
    if (!tried && tried.error().fault == Fault::Aborted) return tried;
    (tried ? free : blocked) = middle;
    if (tried) best = std::move(tried);
  }
  return best;
}

std::string nor(const recipes::Material& m, bool joins) {
  const std::string from_above = m.retract > 0 ? ", nor is one from above" : "";
  if (m.min_speed <= 0)
    return fmt::format("no shorter one is free{}, nor {}", from_above,
                       joins ? "the place where it was cut" : "the bead's start");
  return fmt::format("none from 'min_speed', {:.6g} mm/s, on is free{}; a lower one needs less of it", m.min_speed,
                     from_above);
}

}  // namespace

Result<BegunBead> plan_begin(const motion::Limits& limits, motion::BeadSpec spec, const recipes::Material& material,
                             const IsFree& is_free) {
  const bool joins = spec.begin_mm > 0, stands = !joins && material.start_dwell_s > 0;
  if (stands) spec.entry_mm_s = 0;
  const Beginnings bead(limits, spec, is_free);
  auto whole = bead.whole();
  if (whole || stands || !is_blocked(whole.error(), joins)) return whole;

  const auto stop = [](const Result<BegunBead>& tried) {
    return tried.has_value() || tried.error().fault == Fault::Aborted;
  };
  const auto told = [&](Result<BegunBead> begun) {
    if (begun) begun->how.blocked = whole.error().message;
    return begun;
  };
  auto slower = material.min_speed < spec.speed_mm_s ? fastest_free(bead, spec, material.min_speed)
                                                     : Result<BegunBead>(tl::unexpected(whole.error()));
  const bool moves = slower && slower->how.kind == RunUp::Kind::Shorter;
  if (moves || (!slower && slower.error().fault == Fault::Aborted)) return told(std::move(slower));
  if (material.retract > 0)
    if (auto above = bead.from_above(material.retract); stop(above)) return told(std::move(above));
  if (slower) return told(std::move(slower));
  Error e = whole.error();
  e.message += "; " + nor(material, joins);
  return tl::unexpected(std::move(e));
}

std::string in_words(const RunUp& run_up, const recipes::Material& material) {
  const std::string_view begins = run_up.joins ? "goes on" : "begins";
  switch (run_up.kind) {
    case RunUp::Kind::Shorter:
      if (run_up.entry_mm_s >= 0.999 * material.speed)
        return fmt::format("{} at its speed after a shorter run-up, of {:.2g} mm; {}", begins, run_up.mm,
                           run_up.blocked);
      return fmt::format("{} at {:.3g} mm/s instead of {:.3g} mm/s, after a run-up of {:.2g} mm; {}", begins,
                         run_up.entry_mm_s, material.speed, run_up.mm, run_up.blocked);
    case RunUp::Kind::FromAbove:
      return fmt::format("is come to from above, down and forward at the same time; {}", run_up.blocked);
    case RunUp::Kind::FromRest: return fmt::format("{} from rest, without a run-up; {}", begins, run_up.blocked);
    case RunUp::Kind::Whole: break;
  }
  return "begins at its speed";
}

}  // namespace gantry::job
