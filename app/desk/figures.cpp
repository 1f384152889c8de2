#include "app/desk/figures.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "app/record/deposit_figures.hpp"
#include "app/record/summary.hpp"
#include "core/units.hpp"

namespace gantry::desk {

std::string figures(const record::JobResult& result) {
  if (result.cycles.cycles == 0) return record::result_word(result) + " before it began";
  std::string text;
  text += fmt::format("{}: {} of {} features, {:.1f} s of motion ({:.1f} s planned)\n", record::result_word(result),
                      result.features_done, result.features_total, result.actual_s, result.predicted_s);
  if (result.has_offset)
    text += fmt::format("  work offset    dx {:+.3f} mm, dy {:+.3f} mm, rot {:+.4f} deg (rms {:.1f} um)\n",
                        result.offset.shift.x, result.offset.shift.y, units::deg(result.offset.rotation),
                        result.offset_rms_mm * 1000);
  if (result.has_world) {
    const record::DepositFigures f = record::deposit_figures(result);
    text += fmt::format("  deposits       {}", result.deposits.size());
    if (f.worst != nullptr)
      text += fmt::format(", worst '{}': {:.1f} um beside, {:.0f} um allowed", f.worst->id, f.worst->error_mm * 1000,
                          f.worst_allowed_mm * 1000);
    if (f.strays > 0) text += fmt::format(", {} on no feature", f.strays);
    text += fmt::format("\n  collisions     {}\n", result.collisions.size());
  }
  if (result.motions_certified > 0) {
    text += fmt::format("  proved free    {} motions\n", result.motions_certified);
    text += fmt::format("    by design    {}\n", job::to_text(result.minimum_clearance.by_design));
    text += fmt::format("    all others   {}\n", job::to_text(result.minimum_clearance.others));
  }
  text +=
      fmt::format("  wake-up        p50 {:.0f} us, p99 {:.0f} us, max {:.0f} us; {} cycles skipped\n",
                  static_cast<double>(result.cycles.wake.p50) / 1e3, static_cast<double>(result.cycles.wake.p99) / 1e3,
                  static_cast<double>(result.cycles.wake.max) / 1e3, result.cycles.skipped);
  text += fmt::format("  setpoint hash  {:016x} over {} ticks{}", result.setpoint_hash, result.setpoint_ticks,
                      result.setpoint_stream_complete ? "" : " (incomplete)");
  return text;
}

std::optional<double> remaining_s(double duration_s, const run::Progress& progress, double override_factor) {
  if (progress.features_total == 0 || override_factor <= 0) return std::nullopt;
  const double done =
      std::min(1.0, static_cast<double>(progress.features_done) / static_cast<double>(progress.features_total));
  return duration_s * (1 - done) / override_factor;
}

}  // namespace gantry::desk
