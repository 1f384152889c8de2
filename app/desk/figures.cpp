#include "app/desk/figures.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "app/record/defects.hpp"
#include "app/record/deposit_figures.hpp"
#include "app/record/next_command.hpp"
#include "app/record/summary.hpp"
#include "core/units.hpp"

namespace gantry::desk {

namespace {

/// The features by name and why, as many as a terminal shows at once.
std::string defects_in_words(const record::JobResult& result) {
  constexpr std::size_t kShown = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(result.defects.size(), kShown); ++i) {
    const record::Defect& d = result.defects[i];
    text +=
        fmt::format("  {:<13}  {}: {}\n", i == 0 ? "defects" : "",
                    d.feature.empty() ? std::string(record::name(d.kind)) : fmt::format("'{}'", d.feature), d.message);
  }
  if (result.defects.size() > kShown)
    text += fmt::format("  {:<13}  and {} more; the report and summary.json have them\n", "",
                        result.defects.size() - kShown);
  return text;
}

std::string names_in_words(const char* what, const std::vector<std::string>& features) {
  constexpr std::size_t kShown = 20;
  if (features.empty()) return "";
  std::string names;
  for (std::size_t i = 0; i < std::min(features.size(), kShown); ++i)
    names += (names.empty() ? "'" : ", '") + features[i] + "'";
  return fmt::format("  {:<13}  {}{}\n", what, names,
                     features.size() > kShown ? fmt::format(" and {} more", features.size() - kShown) : "");
}

std::string cut_in_words(const record::JobResult& result) {
  std::vector<std::string> cut;
  for (const record::Defect& d : result.defects)
    if (d.kind == record::Defect::Kind::Cut) cut.push_back(d.feature);
  return names_in_words("cut", cut);
}

/// Files that the job's folder lacks, one a line: the log of whoever wrote it is not the client's.
std::string not_kept_in_words(const record::JobResult& result) {
  constexpr std::size_t kShown = 10;
  std::string text;
  for (std::size_t i = 0; i < std::min(result.not_kept.size(), kShown); ++i)
    text +=
        fmt::format("\n  {:<13}  {}: {}", i == 0 ? "not kept" : "", result.not_kept[i].file, result.not_kept[i].why);
  if (result.not_kept.size() > kShown)
    text += fmt::format("\n  {:<13}  and {} more", "", result.not_kept.size() - kShown);
  return text;
}

std::string to_finish_in_words(const record::JobResult& result) {
  if (!result.unseen.empty())
    return fmt::format(
        "\n  nobody saw     what of `{}` lies there: a job on this board was lost. Look at it and dispense of "
        "that what is missing, or take it out: {}",
        result.unseen, record::part_removed_command(result));
  if (result.to_finish.empty()) return "";
  return "\n  to finish it   " + record::finish_command(result);
}

}  // namespace

std::string figures(const record::JobResult& result) {
  if (result.cycles.cycles == 0)
    return (result.bus.empty() && !result.dry_run ? std::string("no bus was opened") : record::bus_in_words(result)) +
           ": the job " + record::result_word(result) + " before it began; the board is " +
           std::string(record::name(result.board)) + not_kept_in_words(result) + to_finish_in_words(result);
  std::string text;
  text += fmt::format("{}: {}: {} of {} features, {:.1f} s of motion ({:.1f} s planned)\n",
                      record::bus_in_words(result), record::result_word(result), result.features_done,
                      result.features_total, result.actual_s, result.predicted_s);
  text += fmt::format("  board          {}\n", record::name(result.board));
  text += defects_in_words(result) + cut_in_words(result) + names_in_words("once more", result.once_more);
  if (result.order == recipes::Order::Shortest)
    text += fmt::format("  travel         {:.1f} mm between features, {:.1f} mm in the order of the file\n",
                        result.travel.as_ordered_mm, result.travel.in_file_order_mm);
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
    if (f.worst_gap != nullptr)
      text += fmt::format(", '{}': {:.1f} um off its gap, {:.0f} um allowed", f.worst_gap->id, f.worst_gap_mm * 1000,
                          f.worst_gap_allowed_mm * 1000);
    if (f.strays > 0) text += fmt::format(", {} on no feature", f.strays);
    text += fmt::format("\n  collisions     {}\n", result.collisions.size());
  }
  if (result.motions_certified > 0) {
    text += fmt::format("  proved free    {} motions\n", result.motions_certified);
    text += fmt::format("    by design    {}\n", job::to_text(result.minimum_clearance.by_design));
    text += fmt::format("    all others   {}\n", job::to_text(result.minimum_clearance.others));
  }
  if (!result.cycles.virtual_time)
    text += fmt::format("  wake-up        p50 {:.0f} us, p99 {:.0f} us, max {:.0f} us; {} cycles skipped\n",
                        static_cast<double>(result.cycles.wake.p50) / 1e3,
                        static_cast<double>(result.cycles.wake.p99) / 1e3,
                        static_cast<double>(result.cycles.wake.max) / 1e3, result.cycles.skipped);
  if (const auto& frames = result.cycles.frames; frames.lost > 0)
    text += fmt::format("  bus            {} of {} frames did not come back; {} in a row stop the machine\n",
                        frames.lost, frames.sent, result.cycles.frames_lost_max);
  text += fmt::format("  setpoint hash  {:016x} over {} ticks{}", result.setpoint_hash, result.setpoint_ticks,
                      result.setpoint_stream_complete ? "" : " (incomplete)");
  text += not_kept_in_words(result) + to_finish_in_words(result);
  return text;
}

}  // namespace gantry::desk
