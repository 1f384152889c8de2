#include "app/job/run_up.hpp"

#include <fmt/format.h>
#include <utility>

#include "motion/profile/speed_profile.hpp"

namespace gantry::job {
namespace {

constexpr int kSteps = 16;  // of the entry speed, between `min_speed` and the bead's own

/// One way to begin it.
class Beginnings {
 public:
  Beginnings(const motion::Limits& limits, const motion::BeadSpec& spec, const IsFree& is_free)
      : limits_(limits), spec_(spec), is_free_(is_free) {}

  Result<BegunBead> whole() const { return attempt(spec_, RunUp::Kind::Whole); }
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
  Result<BegunBead> attempt(const motion::BeadSpec& spec, RunUp::Kind kind) const {
    auto planned = motion::plan_bead(limits_, spec);
    if (!planned) return tl::unexpected(planned.error());
    BegunBead out{*std::move(planned), {.kind = kind}};
    out.how.mm = out.motion.run_up_mm;
    for (std::size_t k = out.motion.bead_begin; k < out.motion.bead_end; ++k)
      if (const motion::Segment& s = out.motion.segments[k]; s.kind == motion::SegmentKind::Piece) {
        out.how.entry_mm_s = s.nominal.v0;
        break;
      }
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

/// What another run-up may be the answer to.
bool is_blocked(const Error& e) { return e.fault == Fault::Collision || e.fault == Fault::SpeedNotReachable; }

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

std::string nor(const recipes::Material& m) {
  const std::string from_above = m.retract > 0 ? ", nor is one from above" : "";
  if (m.min_speed <= 0) return fmt::format("no shorter one is free{}, nor the bead's start", from_above);
  return fmt::format("none from 'min_speed', {:.6g} mm/s, on is free{}; a lower one needs less of it", m.min_speed,
                     from_above);
}

}  // namespace

Result<BegunBead> plan_begin(const motion::Limits& limits, motion::BeadSpec spec, const recipes::Material& material,
                             const IsFree& is_free) {
  if (material.start_dwell_s > 0) spec.entry_mm_s = 0;
  const Beginnings bead(limits, spec, is_free);
  auto whole = bead.whole();
  if (whole || material.start_dwell_s > 0 || !is_blocked(whole.error())) return whole;

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
  e.message += "; " + nor(material);
  return tl::unexpected(std::move(e));
}

std::string in_words(const RunUp& run_up, const recipes::Material& material) {
  switch (run_up.kind) {
    case RunUp::Kind::Shorter:
      return fmt::format("begins at {:.3g} mm/s instead of {:.3g} mm/s, after a run-up of {:.2g} mm; {}",
                         run_up.entry_mm_s, material.speed, run_up.mm, run_up.blocked);
    case RunUp::Kind::FromAbove:
      return fmt::format("is come to from above, down and forward at the same time; {}", run_up.blocked);
    case RunUp::Kind::FromRest: return fmt::format("begins from rest, without a run-up; {}", run_up.blocked);
    case RunUp::Kind::Whole: break;
  }
  return "begins at its speed";
}

}  // namespace gantry::job
