#include "app/record/report_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <limits>
#include <utility>

#include "app/record/defects.hpp"
#include "app/record/deposit_figures.hpp"
#include "app/record/html.hpp"
#include "app/record/html_table.hpp"
#include "app/record/next_command.hpp"
#include "app/record/report_plots.hpp"
#include "app/record/setpoint_hash.hpp"
#include "app/record/summary.hpp"
#include "core/units.hpp"

namespace gantry::record {
namespace {

using html::micrometres, html::number, html::section, html::span_of_time, html::Table, html::text;

constexpr std::size_t kDepositsShown = 60;

std::string point(Vec2 p) { return number(p.x, 2) + ", " + number(p.y, 2); }

/// A length in µm, red when it is beyond its limit or unknown.
std::string limited(double mm, double limit_mm) {
  return std::abs(mm) <= limit_mm ? micrometres(mm) : "<span class=\"bad\">" + micrometres(mm) + "</span>";
}

/// 61234 -> "61 234", with a narrow space that does not break.
std::string grouped(std::uint64_t n) {
  auto digits = std::to_string(n);
  for (std::size_t i = digits.size(); i > 3; i -= 3) digits.insert(i - 3, "\u202F");
  return digits;
}

std::string tile(std::string_view value, std::string_view label, const char* css = "") {
  return fmt::format("<div class=\"tile {}\"><b>{}</b><span>{}</span></div>", css, text(value), text(label));
}

std::string meter(double part) {
  return fmt::format("<span class=\"meter\" style=\"width:{:.0f}px\"></span>", std::clamp(part, 0.0, 1.0) * 140);
}

}  // namespace

std::string headline(const JobResult& r) {
  const auto word = result_word(r);
  std::string verdict = word == "done"                ? "Done"
                        : word == "done_with_defects" ? "Done with defects"
                        : word == "interrupted"       ? "Interrupted"
                        : word == "aborted"           ? "Aborted"
                                                      : "Failed";
  const char* css = word == "done" ? "" : word == "failed" ? "failed" : "warn";
  auto out = fmt::format("<header><h1>{}</h1><span class=\"verdict {}\">{}</span></header>",
                         text(r.recipe_name.empty() ? r.job : r.recipe_name), css, verdict);
  std::vector<std::string> facts;
  facts.push_back(r.dry_run ? "dry run in virtual time" : "run in real time");
  if (!r.machine_name.empty()) facts.push_back("machine " + r.machine_name);
  facts.push_back(bus_in_words(r) + " bus");
  if (!r.origin.serial.empty()) facts.push_back("serial " + r.origin.serial);
  facts.push_back("board " + std::string(name(r.board)));
  if (!r.started.empty()) facts.push_back(r.started);
  facts.push_back("job " + r.job);
  out += fmt::format("<p class=\"sub\">{}</p>", text(fmt::format("{}", fmt::join(facts, " · "))));
  return out;
}

std::string defect_section(const JobResult& r) {
  if (r.defects.empty()) return {};
  constexpr std::size_t kShown = 100;
  Table table({"feature", "", "why"});
  for (std::size_t i = 0; i < std::min(r.defects.size(), kShown); ++i) {
    const Defect& d = r.defects[i];
    table.row({fmt::format("<span class=\"name\">{}</span>", d.feature.empty() ? "the board" : text(d.feature)),
               fmt::format("<span class=\"bad\">{}</span>", name(d.kind)),
               fmt::format("<span class=\"prose\">{}</span>", text(d.message))});
  }
  std::string body = table.done();
  if (r.defects.size() > kShown)
    body += fmt::format("<p class=\"note\">The first {} of {}; summary.json has all.</p>", kShown, r.defects.size());
  return section(fmt::format("Defects: {}", r.defects.size()), body);
}

std::string finish_section(const JobResult& r) {
  if (!r.unseen.empty())
    return section(
        "What nobody saw",
        fmt::format("<p class=\"note\">A job on this board was lost, and nobody saw what of <code>{}</code> lies "
                    "there. Look at it and dispense of that what is missing; or take it out and say "
                    "<code>{}</code>.</p>",
                    text(r.unseen), text(part_removed_command(r))));
  if (r.to_finish.empty()) return {};
  return section("To finish the board",
                 fmt::format("<p class=\"note\"><code>{}</code>; or take it out and say <code>{}</code>.</p>",
                             text(finish_command(r)), text(part_removed_command(r))));
}

std::string tiles(const JobResult& r) {
  std::string out = "<div class=\"tiles\">";
  out += tile(fmt::format("{} / {}", r.features_done, r.features_total), "features dispensed",
              r.features_done < r.features_total ? "warn" : "");
  out += tile(span_of_time(r.actual_s),
              r.predicted_s > 0 ? "motion, predicted " + span_of_time(r.predicted_s) : "motion, never planned");
  if (r.order == recipes::Order::Shortest)
    out += tile(number(r.travel.as_ordered_mm, 1) + " mm",
                "travel between features, in the order of the file " + number(r.travel.in_file_order_mm, 1) + " mm");
  if (r.has_world) {
    const DepositFigures f = deposit_figures(r);
    if (f.worst != nullptr) {
      out += tile(micrometres(f.worst->error_mm),
                  "worst lateral error, allowed there " + micrometres(f.worst_allowed_mm), f.within() ? "" : "warn");
      out += tile(micrometres(f.worst_gap_mm),
                  "largest gap deviation, allowed there " + micrometres(f.worst_gap_allowed_mm),
                  f.gaps_within ? "" : "warn");
    }
    if (f.strays > 0) out += tile(std::to_string(f.strays), "deposits on no feature, 0 allowed", "bad");
    out += tile(std::to_string(r.collisions.size()), "collisions, 0 allowed", r.collisions.empty() ? "" : "bad");
  }
  if (r.cycles.cycles > 0)
    out += tile(std::to_string(r.cycles.deadline_misses),
                "deadline misses in " + grouped(r.cycles.cycles) + " cycles; 0 wanted",
                r.cycles.deadline_misses > 0 ? "warn" : "");
  return out + "</div>\n";
}

std::string error_section(const JobResult& r) {
  if (r.errors.empty()) return {};
  std::string body;
  for (const auto& e : r.errors) {
    const FaultInfo& f = info(e.fault);
    body += fmt::format("<div class=\"error\" style=\"padding-left:14px\"><b>{}</b><br>{}", text(e.message),
                        e.where.empty() ? "" : "<code>" + text(e.where) + "</code><br>");
    if (!f.remedy.empty()) body += "<span class=\"sub\">What to do: " + text(f.remedy) + "</span><br>";
    body += fmt::format("<span class=\"note\">{} {}</span></div>", std::string_view(code(e.fault)), text(f.name));
  }
  if (!r.interrupted.empty())
    body += fmt::format("<p class=\"note\">Cut while dispensing: {}. Look at them before going on.</p>",
                        text(fmt::format("{}", fmt::join(r.interrupted, ", "))));
  return section("What stopped the job", body);
}

std::string joined_section(const JobResult& r) {
  if (r.joined.empty()) return {};
  Table table({"bead", ">joined at (mm)", ">shut for (s)"});
  for (const Joined& each : r.joined) table.row({text(each.feature), number(each.at_mm, 2), number(each.after_s, 1)});
  return section("Beads that a hold has cut", table.done() +
                                                  "<p class=\"note\">Joined where their valve had shut. What the "
                                                  "virtual world found missing there stands with the "
                                                  "deposit in summary.json.</p>");
}

std::string mark_section(const JobResult& r) {
  if (r.marks.empty()) return {};
  std::string body = "<div class=\"marks\">";
  for (const auto& m : r.marks) {
    body += "<figure>";
    body += m.png.empty() ? std::string("<div class=\"noimage\">no image</div>")
                          : fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">", text("mark " + m.name),
                                        html::base64(m.png));
    body += "<figcaption><b>" + text(m.name) + "</b> at " + point(m.nominal) + "<br>";
    if (m.found) {
      body += "found at " + point(m.measured);
      if (r.has_offset) body += ", residual " + micrometres(m.residual_mm);
    } else {
      body += "<span class=\"bad\">not found</span>" + (m.reason.empty() ? std::string() : ": " + text(m.reason));
    }
    if (m.attempts > 1) body += fmt::format(", {} attempts", m.attempts);
    body += "</figcaption></figure>";
  }
  body += "</div>";
  if (r.has_offset)
    body += fmt::format(
                "<p class=\"note\">The board lies {} mm, {} mm and {}° from its nominal position (residual {} rms).",
                number(r.offset.shift.x, 3), number(r.offset.shift.y, 3), number(units::deg(r.offset.rotation), 3),
                micrometres(r.offset_rms_mm)) +
            (r.length_only
                 ? " Trust: length only; of two marks nothing but their distance shows that they are the right ones."
                 : "");
  else
    body += "<p class=\"note\">No work offset was fitted.";
  if (!r.placement.empty()) body += " The virtual board was placed at " + text(r.placement) + ".";
  return section("Marks", body + "</p>");
}

std::string height_section(const JobResult& r) {
  if (r.touches.empty()) return {};
  Table table({"touch", "at (mm)", ">height (mm)", ">residual"});
  for (const auto& t : r.touches)
    table.row({text(t.name), point(t.at), number(t.height_mm, 3), micrometres(t.residual_mm)});
  if (!r.has_surface)
    return section("Touched heights", table.done() + "<p class=\"note\">The job ended before they were a surface.</p>");
  return section("Touched heights",
                 table.done() + fmt::format("<p class=\"note\">Surface: {} mm at the board's origin, slope {} and {} "
                                            "µm/mm in x and y, over the nominal top face.</p>",
                                            number(r.surface.z0, 3), number(r.surface.slope.x * 1000, 2),
                                            number(r.surface.slope.y * 1000, 2)));
}

std::string deposit_section(const JobResult& r) {
  if (!r.has_world || r.deposits.empty()) return {};
  std::vector<std::pair<double, const Deposit*>> worst;  // by its part of what is allowed
  for (const auto& d : r.deposits)
    if (d.kind != sim::kPurgeKind) worst.emplace_back(part_of_allowed(r, d), &d);
  std::stable_sort(worst.begin(), worst.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  Table table({"deposit", "kind", "at (mm)", ">lateral error", "", ">allowed", ">gap (mm)", ">asked (mm)", ">off by"});
  for (std::size_t i = 0; i < std::min(worst.size(), kDepositsShown); ++i) {
    const auto& d = *worst[i].second;
    const Allowed may = allowed(r, d);
    const auto at = d.board_mm.empty() ? std::string("–") : point({d.board_mm.front().x, d.board_mm.front().y});
    table.row({d.id.empty() ? "<span class=\"bad\">on no feature</span>" : text(d.id), text(d.kind), at,
               limited(d.error_mm, may.beside_mm),
               fmt::format("<span class=\"meter\" style=\"width:{:.0f}px;background:{}\"></span>",
                           std::clamp(std::isfinite(d.error_mm) ? d.error_mm / may.beside_mm : 1.0, 0.0, 1.5) * 80,
                           error_colour(d.error_mm / may.beside_mm)),
               micrometres(may.beside_mm), number(d.gap_mm, 3), number(d.asked_gap_mm, 3),
               limited(d.gap_mm - d.asked_gap_mm, may.gap_mm)});
  }
  std::string note =
      "<p class=\"note\">As the virtual world saw the needle while the valve was open; the worst first, by its part of "
      "what is allowed, beside or off its gap: the material's tolerances, and of a bead what its corners may be "
      "rounded by.";
  if (worst.size() > kDepositsShown)
    note += fmt::format(" The {} worst of {}; summary.json has all.", kDepositsShown, worst.size());
  return section("Deposits", table.done() + note + "</p>");
}

std::string length_section(const JobResult& r) {
  const auto rows = laid_lengths(r);
  if (rows.empty()) return {};
  Table table({"bead", "kind", ">by the recipe (mm)", ">dispensed (mm)", ">area (mm²)", ">lines apart (mm)"});
  for (std::size_t i = 0; i < std::min(rows.size(), kDepositsShown); ++i) {
    const LaidLength& row = rows[i];
    const auto optional = [](const std::optional<double>& v, int digits) {
      return v ? number(*v, digits) : std::string();
    };
    table.row({text(row.name) + (row.beads > 1 ? fmt::format(" ({} beads)", row.beads) : ""), text(row.kind),
               number(row.drawn_mm, 2), optional(row.laid_mm, 2), optional(row.area_mm2, 1),
               optional(row.spacing_mm, 2)});
  }
  std::string note = "<p class=\"note\">Lengths of curves are their own; a needle that rounds corners goes less far.";
  if (rows.size() > kDepositsShown)
    note += fmt::format(" The first {} of {}; summary.json has all.", kDepositsShown, rows.size());
  return section("Lengths", table.done() + note + "</p>");
}

std::string following_section(const JobResult& r) {
  if (r.axes.empty()) return {};
  bool open_loop = false;
  Table table({"axis", ">largest", "", ">allowed at that speed", ">at rest", ">at full speed"});
  for (const auto& a : r.axes) {
    open_loop = open_loop || !a.measured;
    const auto length = [&](double v) { return a.rotary ? number(v * 1000, 2) + " mrad" : micrometres(v); };
    const bool watched = a.measured && a.allowed_there > 0;
    table.row({text(a.name), a.measured ? length(a.max_following) : "n/a",
               watched ? meter(a.max_following / a.allowed_there) : "", watched ? length(a.allowed_there) : "",
               watched ? length(a.allowed_at_rest) : "", watched ? length(a.allowed_at_v_max) : ""});
  }
  std::string plots;
  for (const auto& a : r.axes)
    if (const std::string view = following_view(a); !view.empty())
      plots += fmt::format("<h3>{}, {}</h3>{}", text(a.name), a.rotary ? "mrad" : "µm", view);
  return section("Following error",
                 table.done() + plots +
                     "<p class=\"note\">The window grows with the axis' speed; an axis that leaves it stops. Bars "
                     "are parts of the window at the speed that the axis had then. In the plots the dashed line is "
                     "what is allowed." +
                     (open_loop ? " n/a: an open-loop axis (or one that never was enabled in a block) reports its "
                                  "command, not where it is."
                                : "") +
                     "</p>");
}

/// What became of the frames, as the bus has counted them; only what there was.
std::string wire_words(const CycleStatistics& c) {
  const devices::CyclicCounts& f = c.frames;
  std::string words = fmt::format("{} frames sent", grouped(f.sent));
  const auto add = [&](std::uint64_t count, const char* what) {
    if (count > 0) words += fmt::format(", {} {}", grouped(count), what);
  };
  add(f.not_sent, "not taken by the interface");
  add(f.lost, "lost");
  add(f.late, "late");
  add(f.duplicate, "twice");
  add(f.foreign, "of another master");
  add(f.malformed, "changed on the way");
  add(f.untouched, "back as they were sent");
  add(f.wkc_zero, "cycles that no station took part in");
  add(f.wkc_low, "cycles with fewer stations than expected");
  add(f.wkc_high, "cycles with more stations than expected");
  add(c.mailbox_repeats, "mailbox repeats");
  return words + ".";
}

std::string cycle_section(const JobResult& r) {
  const auto& c = r.cycles;
  if (c.cycles == 0) return {};
  const std::string counted =
      fmt::format("{} cycles: {} skipped in {} stalls, {} without an answer, {} wrong working counters. {}",
                  grouped(c.cycles), c.skipped, c.stalls, c.frames_lost, c.working_counter_errors, wire_words(c));
  if (c.virtual_time)
    return section("Cycle",
                   "<p>" + counted +
                       "</p><p class=\"note\">In virtual time nobody waits, and the clock stands while the loop "
                       "works: there are no times to measure.</p>");
  Table table({"", ">median", ">99 %", ">99.9 %", ">max"});
  const auto row = [&](const char* name, const Quantiles& q) {
    const auto t = [](std::int64_t ns) { return html::duration(static_cast<double>(ns)); };
    table.row({name, t(q.p50), t(q.p99), t(q.p999), t(q.max)});
  };
  row("late by", c.wake);
  row("own work", c.compute);
  row("bus", c.bus);
  return section("Cycle",
                 table.done() + histogram_view(c.wake_histogram) +
                     fmt::format("<p class=\"note\">How late the loop woke, how often against how long. {} "
                                 "Real-time priority: {}; memory locked: {}.</p>",
                                 counted, c.real_time_priority ? "yes" : "no", c.memory_locked ? "yes" : "no"));
}

std::string operator_section(const JobResult& r) {
  if (r.actions.empty()) return {};
  Table table({"UTC", "job, s", "order or button"});
  for (const Stamped& action : r.actions)
    table.row({text(action.utc), fmt::format("{:.1f}", action.t_s),
               fmt::format("<span class=\"prose\">{}</span>", text(action.what))});
  return section("What the operator did", "<div class=\"scroll\">" + table.done() + "</div>");
}

std::string event_section(const JobResult& r) {
  if (r.events.empty()) return {};
  std::string lines;
  for (const auto& e : r.events) lines += text(e) + "\n";
  return section("Events", "<div class=\"scroll\"><pre class=\"events mono\">" + lines + "</pre></div>");
}

std::string fact_section(const JobResult& r) {
  std::string list = "<dl>";
  const auto fact = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) list += "<dt>" + text(name) + "</dt><dd>" + text(value) + "</dd>";
  };
  fact("recipe", r.recipe_file);
  fact("its SHA-256", r.origin.recipe_sha256);
  fact("machine file", r.origin.machine_file);
  fact("its SHA-256", r.origin.machine_sha256);
  for (std::size_t i = 1; i < r.sources.size(); ++i)
    fact("with", fmt::format("{}, SHA-256 {}", r.sources[i].file, r.sources[i].sha256));
  for (const recipes::Source& p : r.origin.profiles) fact("profile", fmt::format("{}, SHA-256 {}", p.file, p.sha256));
  fact("blocks", fmt::format("{} of {}", r.blocks_done, r.blocks_total));
  if (r.motions_certified > 0) {
    fact("certificate", fmt::format("{} motions proved free", r.motions_certified));
    fact("proved", job::to_text(r.proofs));
    fact("nearest by design", job::to_text(r.minimum_clearance.by_design));
    fact("nearest of all others", job::to_text(r.minimum_clearance.others));
  }
  fact("valve", fmt::format("opened {} times, {} in all", r.valve_openings, span_of_time(r.valve_open_s)));
  if (r.purge_shots > 0) fact("purged", fmt::format("with {} shots before the first deposit", r.purge_shots));
  if (r.setpoint_ticks > 0)
    fact("setpoint hash",
         r.setpoint_stream_complete
             ? fmt::format("{} over {} ticks", hash_text(r.setpoint_hash), r.setpoint_ticks)
             : fmt::format("{}, but cycles are missing from the record: not comparable", hash_text(r.setpoint_hash)));
  if (r.wall_s > 0) fact("time on the host", span_of_time(r.wall_s));
  for (const auto& f : r.environment) fact(f.name, f.value);
  return section("Particulars", list + "</dl>");
}

}  // namespace gantry::record
