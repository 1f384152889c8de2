#include "app/record/summary.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <variant>

#include "app/record/defects.hpp"
#include "app/record/deposit_figures.hpp"
#include "app/record/json_number.hpp"
#include "app/record/program.hpp"
#include "app/record/setpoint_hash.hpp"
#include "app/record/write_file.hpp"
#include "core/clean_text.hpp"
#include "core/units.hpp"

namespace gantry::record {
namespace {

using Json = nlohmann::ordered_json;

Json point(Vec2 p) { return Json::array({number(p.x), number(p.y)}); }
Json point(Vec3 p) { return Json::array({number(p.x), number(p.y), number(p.z)}); }
Json numbers(const std::vector<double>& list) {
  Json out = Json::array();
  for (const double v : list) out.push_back(number(v));
  return out;
}
/// Every such one, and the last.
Json points(const std::vector<Vec3>& list, std::size_t every = 1) {
  Json result = Json::array();
  for (std::size_t i = 0; i < list.size(); ++i)
    if (i % every == 0 || i + 1 == list.size()) result.push_back(point(list[i]));
  return result;
}

/// A bead has a point for each cycle. Where all of them have more than can be read at once, every second, third ... is
/// told; deposits.csv has all.
std::size_t every_point(const std::vector<Deposit>& deposits) {
  constexpr std::size_t kMost = 100'000;
  std::size_t all = 0;
  for (const Deposit& d : deposits) all += d.kind == "bead" ? d.board_mm.size() : 0;
  return std::max<std::size_t>(1, (all + kMost - 1) / kMost);
}

Json nearest(const std::optional<job::Nearest>& n) {
  if (!n) return nullptr;
  return {{"distance_mm", number(n->distance_mm)},
          {"pair", Json::array({n->head, n->standing})},
          {"motion", n->motion},
          {"where", n->where},
          {"at_mm", n->board_mm ? point(*n->board_mm) : Json(nullptr)},
          {"machine_mm", point(n->machine_mm)}};
}

Json errors(const JobResult& r) {
  Json list = Json::array();
  for (const auto& e : r.errors) {
    const FaultInfo& f = info(e.fault);
    list.push_back({{"code", std::string(code(e.fault))},
                    {"name", std::string(f.name)},
                    {"message", e.message},
                    {"where", e.where},
                    {"remedy", std::string(f.remedy)}});
  }
  return list;
}

/// Text that may be missing.
Json known(const std::string& text) { return text.empty() ? Json(nullptr) : Json(text); }

Json stamped(const std::vector<Stamped>& list) {
  Json out = Json::array();
  for (const Stamped& s : list) {
    Json one{{"utc", s.utc}, {"t_s", number(s.t_s)}, {"what", s.what}};
    if (!s.code.empty()) one["code"] = s.code;
    out.push_back(std::move(one));
  }
  return out;
}

Json counts(const JobResult& r) {
  const auto of_kind = [&](const char* kind) {
    return std::count_if(r.deposits.begin(), r.deposits.end(), [&](const Deposit& d) { return d.kind == kind; });
  };
  const auto found = std::count_if(r.marks.begin(), r.marks.end(), [](const MarkResult& m) { return m.found; });
  Json j{{"blocks_done", r.blocks_done},
         {"blocks_total", r.blocks_total},
         {"features_done", r.features_done},
         {"features_total", r.features_total},
         {"features_interrupted", r.interrupted.size()},
         {"marks_found", found},
         {"marks_total", std::max(r.marks_total, r.marks.size())},
         {"touches", r.touches.size()},
         {"valve_openings", r.valve_openings},
         {"purge_shots", r.purge_shots}};
  j["dots"] = r.has_world ? Json(of_kind("dot")) : Json(nullptr);
  j["beads"] = r.has_world ? Json(of_kind("bead")) : Json(nullptr);
  return j;
}

Json joined(const JobResult& r) {
  Json out = Json::array();
  for (const Joined& each : r.joined)
    out.push_back({{"feature", each.feature}, {"at_mm", number(each.at_mm)}, {"after_s", number(each.after_s)}});
  return out;
}

Json marks(const JobResult& r) {
  Json list = Json::array();
  for (const auto& m : r.marks) {
    Json j{{"name", m.name}, {"found", m.found}, {"nominal_mm", point(m.nominal)}};
    j["measured_mm"] = m.found ? point(m.measured) : Json(nullptr);
    j["residual_mm"] = m.found && r.has_offset ? number(m.residual_mm) : Json(nullptr);
    j["attempts"] = m.attempts;
    if (!m.reason.empty()) j["reason"] = m.reason;
    list.push_back(std::move(j));
  }
  return list;
}

Json heights(const JobResult& r) {
  Json list = Json::array();
  for (const auto& t : r.touches)
    list.push_back({{"name", t.name},
                    {"at_mm", point(t.at)},
                    {"height_mm", number(t.height_mm)},
                    {"residual_mm", number(t.residual_mm)}});
  return list;
}

Json microseconds_of(const Quantiles& q) {
  const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / 1000.0; };
  return {{"p50", us(q.p50)}, {"p99", us(q.p99)}, {"p99_9", us(q.p999)}, {"max", us(q.max)}};
}

Json cycle(const CycleStatistics& c) {
  // In virtual time nobody waits: there is nothing to measure.
  const auto measured = [&](const Quantiles& q) { return c.virtual_time ? Json(nullptr) : microseconds_of(q); };
  return {{"cycles", c.cycles},
          {"sent", c.sent},
          {"skipped", c.skipped},
          {"stalls", c.stalls},
          {"deadline_misses", c.deadline_misses},
          {"frames_lost", c.frames_lost},
          {"frames_lost_max", c.frames_lost_max},
          {"frames", to_json(c.frames)},
          {"mailbox_repeats", c.mailbox_repeats},
          {"working_counter_errors", c.working_counter_errors},
          {"wake_us", measured(c.wake)},
          {"compute_us", measured(c.compute)},
          {"bus_us", measured(c.bus)},
          {"real_time_priority", c.real_time_priority},
          {"memory_locked", c.memory_locked},
          {"virtual_time", c.virtual_time}};
}

void add_following(Json& j, const JobResult& r) {
  Json values = Json::object(), allowed = Json::object(), units = Json::object();
  for (const auto& a : r.axes) {
    allowed[a.name] = a.measured && a.allowed_there > 0 ? number(a.allowed_there) : Json(nullptr);
    values[a.name] = a.measured && std::isfinite(a.max_following) ? number(a.max_following) : Json("n/a");
    units[a.name] = a.rotary ? "rad" : "mm";
  }
  j["max_following_error"] = std::move(values);
  j["max_following_error_allowed"] = std::move(allowed);
  j["max_following_error_units"] = std::move(units);
}

void add_world(Json& j, const JobResult& r) {
  if (!r.has_world) {
    j["collisions"] = nullptr;
    j["collision_list"] = nullptr;
    j["deposits"] = nullptr;
    return;
  }
  Json collisions = Json::array(), deposits = Json::array();
  for (const auto& c : r.collisions)
    collisions.push_back(
        {{"moving", c.moving}, {"standing", c.standing}, {"at_mm", point(c.at)}, {"t_s", number(c.t_s)}});
  const std::size_t every = every_point(r.deposits);
  for (const auto& d : r.deposits) {
    Json& told = deposits.emplace_back(Json{{"id", d.id},
                                            {"kind", d.kind},
                                            {"nominal_mm", points(d.nominal_mm)},
                                            {"board_mm", points(d.board_mm, every)},
                                            {"error_mm", number(d.error_mm)},
                                            {"gap_mm", number(d.gap_mm)},
                                            {"open_ms", number(d.open_s * 1e3)}});
    if (!d.joins_mm.empty()) told["joins_mm"] = numbers(d.joins_mm);
    if (d.speed)
      told["speed_mm_s"] = Json{{"asked", number(d.speed->asked_mm_s)},
                                {"min", number(d.speed->least_mm_s)},
                                {"max", number(d.speed->most_mm_s)}},
      told["within_5_percent"] = number(d.speed->within_5_percent),
      told["volume_per_length"] = number(d.speed->volume_per_length);
  }
  j["collisions"] = r.collisions.size();
  j["collision_list"] = std::move(collisions);
  j["deposits"] = std::move(deposits);
}

Json steps(const JobResult& r) {
  Json list = Json::array();
  for (const job::StepTaken& s : r.steps)
    list.push_back({{"what", s.what},
                    {"predicted_s", s.predicted_s ? number(*s.predicted_s) : Json(nullptr)},
                    {"actual_s", number(s.actual_s)},
                    {"done", s.done},
                    {"disturbed", s.disturbed}});
  return list;
}

/// Those of features that the job dispenses.
Json feature_times(const JobResult& r) {
  Json list = Json::array();
  for (std::size_t i = 0; i < r.feature_times.size(); ++i) {
    const job::FeatureTaken& f = r.feature_times[i];
    if (f.predicted.on_it_s == 0 && f.actual.on_it_s == 0) continue;
    list.push_back({{"id", i < r.feature_names.size() ? r.feature_names[i] : std::string()},
                    {"predicted_s", number(f.predicted.on_it_s)},
                    {"actual_s", number(f.actual.on_it_s)},
                    {"travel_predicted_s", number(f.predicted.travel_s)},
                    {"travel_actual_s", number(f.actual.travel_s)},
                    {"disturbed", f.disturbed}});
  }
  return list;
}

Json sources(const JobResult& r) {
  Json list = Json::array();
  for (const recipes::Source& s : r.sources)
    list.push_back({{"file", s.file}, {"bytes", s.bytes}, {"sha256", s.sha256}});
  return list;
}

Json profiles(const JobResult& r) {
  Json list = Json::array();
  for (const recipes::Source& p : r.origin.profiles) list.push_back({{"file", p.file}, {"sha256", p.sha256}});
  return list;
}

Json lengths(const JobResult& r) {
  const auto optional = [](const std::optional<double>& v) { return v ? number(*v) : Json(nullptr); };
  Json list = Json::array();
  for (const LaidLength& row : laid_lengths(r)) {
    Json j{{"name", row.name},
           {"kind", row.kind},
           {"length_mm", number(row.drawn_mm)},
           {"dispensed_mm", optional(row.laid_mm)}};
    if (row.area_mm2)
      j["area_mm2"] = number(*row.area_mm2), j["spacing_mm"] = optional(row.spacing_mm), j["beads"] = row.beads;
    list.push_back(std::move(j));
  }
  return list;
}

/// One line a member, and in a list of objects one line an object: short, and still read by people and by grep.
std::string lines(const Json& document) {
  const auto dump = [](const Json& j) { return j.dump(-1, ' ', false, Json::error_handler_t::replace); };
  std::string out = "{";
  const char* comma = "\n";
  for (const auto& [key, value] : document.items()) {
    out += comma + std::string("  ") + dump(key) + ": ";
    comma = ",\n";
    if (value.is_array() && !value.empty() && value.front().is_object()) {
      for (std::size_t i = 0; i < value.size(); ++i) out += (i == 0 ? "[\n    " : ",\n    ") + dump(value[i]);
      out += "]";
    } else {
      out += dump(value);
    }
  }
  return escape_steering(out + "\n}\n");
}

}  // namespace

std::string result_word(const JobResult& r) {
  if (r.exit_code == ExitCode::Done) return "done";
  if (r.exit_code == ExitCode::DoneWithDefects) return "done_with_defects";
  if (r.exit_code == ExitCode::Interrupted) return "interrupted";
  return !r.errors.empty() && r.errors.front().fault == Fault::Aborted ? "aborted" : "failed";
}

std::string bus_in_words(const JobResult& r) {
  if (r.bus == "sim" || (r.bus.empty() && r.dry_run)) return "VIRTUAL";
  return r.bus.empty() ? "none" : r.bus;
}

nlohmann::ordered_json to_json(const devices::CyclicCounts& c) {
  return {{"sent", c.sent},           {"not_sent", c.not_sent}, {"lost", c.lost},           {"late", c.late},
          {"duplicate", c.duplicate}, {"foreign", c.foreign},   {"malformed", c.malformed}, {"untouched", c.untouched},
          {"wkc_zero", c.wkc_zero},   {"wkc_low", c.wkc_low},   {"wkc_high", c.wkc_high}};
}

nlohmann::ordered_json to_json(const job::Clearances& clearances) {
  return {{"by_design", nearest(clearances.by_design)}, {"others", nearest(clearances.others)}};
}

nlohmann::ordered_json to_json(std::span<const Defect> defects) {
  Json list = Json::array();
  for (const Defect& d : defects)
    list.push_back({{"feature", d.feature}, {"kind", name(d.kind)}, {"message", d.message}});
  return list;
}

nlohmann::ordered_json to_json(const JobResult& r) {
  Json j{{"result", result_word(r)},
         {"exit_code", static_cast<int>(r.exit_code)},
         {"errors", errors(r)},
         {"job", r.job},
         {"board", name(r.board)},
         {"defects", to_json(r.defects)},
         {"to_finish", known(r.to_finish)},
         {"unseen", known(r.unseen)},
         {"recipe", r.recipe_name},
         {"recipe_file", r.recipe_file},
         {"recipe_sha256", known(r.origin.recipe_sha256)},
         {"sources", sources(r)},
         {"machine", r.machine_name},
         {"machine_file", known(r.origin.machine_file)},
         {"machine_sha256", known(r.origin.machine_sha256)},
         {"profiles", profiles(r)},
         {"serial", known(r.origin.serial)},
         {"program", {{"version", program_version()}, {"commit", program_commit()}}},
         {"bus", bus_in_words(r)},
         {"dry_run", r.dry_run},
         {"started", r.started},
         {"counts", counts(r)},
         {"interrupted", r.interrupted},
         {"joined", joined(r)},
         {"once_more", r.once_more},
         {"marks", marks(r)}};
  j["work_offset"] = r.has_offset ? Json{{"dx_mm", number(r.offset.shift.x)},
                                         {"dy_mm", number(r.offset.shift.y)},
                                         {"rot_deg", number(units::deg(r.offset.rotation))},
                                         {"rms_mm", number(r.offset_rms_mm)}}
                                  : Json(nullptr);
  j["trust"] = !r.has_offset ? Json(nullptr) : r.length_only ? Json("length only") : Json("residuals");
  j["heights"] = heights(r);
  j["surface"] =
      r.has_surface ? Json{{"z0_mm", number(r.surface.z0)}, {"slope", point(r.surface.slope)}} : Json(nullptr);
  j["predicted_s"] = r.predicted_s > 0 ? number(r.predicted_s) : Json(nullptr);
  j["actual_s"] = number(r.actual_s);
  j["steps"] = steps(r);
  j["feature_times"] = feature_times(r);
  j["wall_s"] = number(r.wall_s);
  add_following(j, r);
  j["cycle"] = cycle(r.cycles);
  const auto& others = r.minimum_clearance.others;
  j["certificate"] = {{"motions_certified", r.motions_certified},
                      {"minimum_clearance_mm", others ? number(others->distance_mm) : Json(nullptr)},
                      {"minimum_clearance", to_json(r.minimum_clearance)},
                      {"blocks",
                       {{"ahead", r.proofs.ahead},
                        {"at_the_moment", r.proofs.at_the_moment},
                        {"waited", r.proofs.waited},
                        {"waited_s", number(r.proofs.waited_s)}}},
                      {"second_opinion_poses", r.opinion_poses > 0 ? Json(r.opinion_poses) : Json(nullptr)}};
  j["setpoint_hash"] = r.setpoint_ticks > 0 ? Json(hash_text(r.setpoint_hash)) : Json(nullptr);
  j["setpoint_ticks"] = r.setpoint_ticks;
  j["setpoint_stream_complete"] = r.setpoint_stream_complete;
  j["disturbed"] = r.disturbed;
  add_world(j, r);
  j["travel"] = {{"order", r.order == recipes::Order::Shortest ? "shortest" : "file"},
                 {"as_ordered_mm", number(r.travel.as_ordered_mm)},
                 {"in_file_order_mm", number(r.travel.in_file_order_mm)}};
  j["lengths"] = lengths(r);
  j["placement"] = r.placement.empty() ? Json(nullptr) : Json(r.placement);
  j["valve_open_s"] = number(r.valve_open_s);
  j["actions"] = stamped(r.actions);
  j["alarms"] = stamped(r.alarms);
  j["events"] = r.events;
  Json not_kept = Json::array();
  for (const NotKept& each : r.not_kept) not_kept.push_back({{"file", each.file}, {"message", each.why}});
  j["not_kept"] = std::move(not_kept);
  Json environment = Json::object();
  for (const auto& f : r.environment) environment[f.name] = f.value;
  j["environment"] = std::move(environment);
  // Names come from files and drives: text that is no UTF-8 would make dump() throw wherever the document goes next.
  return Json::parse(j.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string summary_text(const JobResult& r, std::span<const std::string> files) {
  auto j = to_json(r);
  std::set<std::string> named(files.begin(), files.end());
  named.insert("summary.json");
  j["files"] = named;
  return lines(j);
}

Result<void> write_summary(const std::string& dir, const JobResult& r, std::span<const std::string> files) {
  return write_file(dir + "/summary.json", summary_text(r, files));
}

}  // namespace gantry::record
