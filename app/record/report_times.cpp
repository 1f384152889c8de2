// What the job took beside what was forecast, and the recipe's own figures.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <numeric>

#include "app/record/html_table.hpp"
#include "app/record/report_tables.hpp"

namespace gantry::record {
namespace {

using html::number, html::section, html::Table, html::text;

constexpr std::size_t kShown = 60;

std::string seconds_of(double s) { return number(s, 3); }

/// "+0.012", or "" where there is nothing to compare, or where something came between.
std::string difference(double actual_s, double predicted_s, bool compared) {
  return compared ? fmt::format("{:+.3f}", actual_s - predicted_s) : std::string();
}

std::string note(std::string_view words) { return fmt::format("<p class=\"note\">{}</p>", words); }

std::string step_table(const JobResult& r) {
  Table table({"step", ">forecast (s)", ">took (s)", ">difference (s)", ""});
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < r.steps.size(); ++i) {
    const job::StepTaken& s = r.steps[i];
    // Of hundreds of marks or touches the first ones; what dispenses and parks comes at the end.
    if (i >= kShown && i + 4 < r.steps.size()) {
      ++left_out;
      continue;
    }
    table.row({text(s.what), s.predicted_s ? seconds_of(*s.predicted_s) : "",
               s.actual_s > 0 ? seconds_of(s.actual_s) : "–",
               difference(s.actual_s, s.predicted_s.value_or(0), s.done && s.predicted_s && !s.disturbed),
               s.disturbed      ? "disturbed"
               : s.done         ? ""
               : s.actual_s > 0 ? "not finished"
                                : "not begun"});
  }
  return table.done() +
         (left_out > 0 ? note(fmt::format("{} steps are left out; summary.json has all.", left_out)) : "");
}

std::string feature_table(const JobResult& r) {
  std::vector<std::size_t> slowest;
  for (std::size_t i = 0; i < r.feature_times.size(); ++i)
    if (r.feature_times[i].actual.on_it_s > 0) slowest.push_back(i);
  if (slowest.empty()) return {};
  const auto whole_s = [&](std::size_t i) {
    return r.feature_times[i].actual.on_it_s + r.feature_times[i].actual.travel_s;
  };
  const double on_it_s = std::accumulate(slowest.begin(), slowest.end(), 0.0, [&](double sum, std::size_t i) {
    return sum + r.feature_times[i].actual.on_it_s;
  });
  const double travel_s = std::accumulate(slowest.begin(), slowest.end(), 0.0, [&](double sum, std::size_t i) {
    return sum + r.feature_times[i].actual.travel_s;
  });
  std::stable_sort(slowest.begin(), slowest.end(),
                   [&](std::size_t a, std::size_t b) { return whole_s(a) > whole_s(b); });
  Table table({"feature", ">travel to it (s)", ">forecast (s)", ">on it (s)", ">forecast (s)", ""});
  for (std::size_t i = 0; i < std::min(slowest.size(), kShown); ++i) {
    const job::FeatureTaken& f = r.feature_times[slowest[i]];
    table.row({slowest[i] < r.feature_names.size() ? text(r.feature_names[slowest[i]]) : "",
               seconds_of(f.actual.travel_s), seconds_of(f.predicted.travel_s), seconds_of(f.actual.on_it_s),
               seconds_of(f.predicted.on_it_s), f.disturbed ? "disturbed" : ""});
  }
  const double all_s = on_it_s + travel_s;
  return fmt::format(
      "<h3>Features, the slowest first</h3><div class=\"scroll\">{}</div>{}", table.done(),
      note(fmt::format("On features {:.1f} s, on the way to them {:.1f} s ({:.0f} %).{}", on_it_s, travel_s,
                       all_s > 0 ? 100 * travel_s / all_s : 0,
                       slowest.size() > kShown
                           ? fmt::format(" The {} slowest of {}; summary.json has all.", kShown, slowest.size())
                           : "")));
}

}  // namespace

std::string speed_section(const JobResult& r) {
  std::vector<const Deposit*> beads;
  for (const Deposit& d : r.deposits)
    if (d.speed) beads.push_back(&d);
  if (beads.empty()) return {};
  std::stable_sort(beads.begin(), beads.end(), [](const Deposit* a, const Deposit* b) {
    return a->speed->within_5_percent < b->speed->within_5_percent;
  });
  Table table(
      {"bead", ">speed asked (mm/s)", ">lowest", ">highest", ">within 5 % (of its length)", ">volume per length"});
  for (std::size_t i = 0; i < std::min(beads.size(), kShown); ++i) {
    const sim::DepositSpeed& v = *beads[i]->speed;
    table.row({text(beads[i]->id), number(v.asked_mm_s, 1), number(v.least_mm_s, 2), number(v.most_mm_s, 2),
               number(v.within_5_percent * 100, 1) + " %", number(v.volume_per_length * 100, 1) + " %"});
  }
  return section("How steadily beads were dispensed",
                 "<div class=\"scroll\">" + table.done() + "</div>" +
                     note(fmt::format("As the virtual world saw the needle while the valve was open, the least steady "
                                      "first. Corners that are rounded are gone through more slowly. Volume of a valve "
                                      "with a steady flow; 100 % is what the asked speed gives.{}",
                                      beads.size() > kShown ? fmt::format(" The first {} of {}; summary.json has all.",
                                                                          kShown, beads.size())
                                                            : "")));
}

std::string times_section(const JobResult& r) {
  if (r.steps.empty()) return {};
  return section(
      "Times",
      step_table(r) + feature_table(r) +
          note("Steps are forecast before the first motion, with the board at its nominal placement: a touch "
               "of a board that lies lower takes longer. Features are forecast anew when it is known where the "
               "board lies. Disturbed: by a hold, a stop or an override."));
}

std::string recipe_section(const JobResult& r) {
  if (r.materials.empty()) return {};
  Table table({"material", ">speed (mm/s)", ">gap (mm)", ">dot (s)", ">settle (s)", ">retract (mm)",
               ">valve ahead, opening / closing (ms)", ">start dwell (s)", ">early off / back track / tail lift (mm)",
               ">least speed (mm/s)", ">joined within (s)", ">override (%)", "flow follows speed", ">tolerance (mm)",
               ">of the gap (mm)", ">of the speed (%)"});
  for (const recipes::Material& m : r.materials)
    table.row({text(m.name), number(m.speed, 1), number(m.gap, 3), number(m.dot_time, 3), number(m.settle_time, 3),
               number(m.retract, 1), fmt::format("{:.1f} / {:.1f}", m.valve_open_lead * 1e3, m.valve_close_lead * 1e3),
               number(m.start_dwell_s, 3),
               fmt::format("{:.3g} / {:.3g} / {:.3g}", m.early_off, m.back_track, m.tail_lift), number(m.min_speed, 1),
               number(m.rejoin_within_s, 1), number(m.override_max * 100, 0), text(m.flow_follows_speed ? "yes" : "no"),
               number(m.tolerance_mm, 3), number(m.gap_tolerance_mm, 3),
               fmt::format("{:.3g}", m.speed_tolerance * 100)});
  return section("The recipe's materials", "<div class=\"scroll\">" + table.done() + "</div>");
}

}  // namespace gantry::record
