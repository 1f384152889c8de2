#include "app/job/proof_inputs.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <iterator>
#include <variant>
#include <vector>

#include "core/sha256.hpp"
#include "recipes/job.hpp"

namespace gantry::job {
namespace {

// Structs are taken apart by structured bindings: one that gets a member does not compile until it is decided here
// whether the proof rests on that.

/// One line of the canonical text: a word, then values, a blank between them.
class Row {
 public:
  explicit Row(std::string_view word) : text_(word) {}
  /// The shortest digits that read back as the same number; -0 is 0.
  Row& add(double v) { return put(fmt::format("{}", v + 0.0)); }
  Row& add(int v) { return put(fmt::format("{}", v)); }
  Row& add(bool v) { return put(v ? "true" : "false"); }
  Row& add(Vec2 v) { return add(v.x).add(v.y); }
  Row& add(Vec3 v) { return add(v.x).add(v.y).add(v.z); }
  Row& add(const char* word) { return put(word); }
  /// In quotes; a quote, a backslash and a line's end have a backslash before them.
  Row& add(const std::string& v) {
    std::string quoted = "\"";
    for (const char c : v) {
      if (c == '"' || c == '\\') quoted += '\\';
      quoted += c == '\n' ? "\\n" : std::string(1, c);
    }
    return put(quoted + '"');
  }
  [[nodiscard]] std::string text() const { return text_ + "\n"; }

 private:
  Row& put(std::string_view value) {
    text_ += ' ';
    text_ += value;
    return *this;
  }
  std::string text_;
};

/// Rows whose order tells nothing.
class Set {
 public:
  void add(const Row& row) { rows_.push_back(row.text()); }
  [[nodiscard]] std::string text() {
    std::sort(rows_.begin(), rows_.end());
    std::string all;
    for (const std::string& row : rows_) all += row;
    return all;
  }

 private:
  std::vector<std::string> rows_;
};

std::string hash_of(const char* name, const std::string& text) {
  return sha256_hex(fmt::format("gantry {} 1\n{}", name, text));
}

Row row(const config::Body& body) {
  constexpr const char* kKinds[] = {"box", "cylinder", "capsule"};
  const auto& [name, shape, centre, rotation_rad, on_lift, on_turn, keep_out] = body;
  const auto& [kind, size] = shape;
  Row out(keep_out ? "keep_out" : "body");
  out.add(name)
      .add(kKinds[static_cast<std::size_t>(kind)])
      .add(size)
      .add(centre)
      .add(rotation_rad)
      .add(on_lift)
      .add(on_turn);
  return out;
}

std::string scene_of(const config::Machine& machine, const recipes::Recipe& recipe) {
  Set rows;
  for (const config::Body& body : machine.scene) rows.add(row(body));
  for (const config::Body& body : recipes::bodies(recipe, machine, {}, {})) rows.add(row(body));
  for (const config::Body& zone : machine.keep_out) rows.add(row(zone));
  for (const config::Body& zone : recipes::zones(recipe, machine)) rows.add(row(zone));
  return rows.text();
}

std::string head_of(const config::Machine& m) {
  Set rows;
  for (const config::Body& body : m.head) rows.add(row(body));
  const auto axis = [&](const std::optional<AxisId>& id) { return id ? m.axes[id->value].name : std::string(); };
  Row carried("carried");
  for (const auto& id : {std::optional(m.x), std::optional(m.y), std::optional(m.z), m.c, m.u}) carried.add(axis(id));
  rows.add(carried);
  return rows.text();
}

std::string limits_text(const config::Machine& m) {
  Set rows;
  for (const config::Axis& a : m.axes) {
    Row axis("axis");
    axis.add(a.name).add(a.kind == config::AxisKind::Streamed ? "streamed" : "positioned").add(a.rotary);
    for (const double v : {a.p_min, a.p_max, a.v_max, a.a_max, a.j_max, a.response_delay_s, a.path_error}) axis.add(v);
    rows.add(axis);
  }
  for (const auto& [axis, position] : m.park) rows.add(Row("park").add(m.axes[axis.value].name).add(position));
  rows.add(Row("clearance").add(m.clearance_mm));
  rows.add(Row("safe_z").add(m.safe_z_mm));
  rows.add(Row("cycle").add(seconds(m.bus.cycle)));
  return rows.text();
}

/// When the camera exposes and answers moves nothing elsewhere.
std::string calibration_of(const config::Machine& m) {
  Set rows;
  for (const config::Tool& tool : m.tools) {
    const auto& [name, tip, lift_mm] = tool;
    rows.add(Row("tool").add(name).add(tip).add(lift_mm));
  }
  for (const config::WorkFrame& frame : m.frames) {
    const auto& [name, origin] = frame;
    rows.add(Row("frame").add(name).add(origin));
  }
  const auto& [width_px, height_px, mm_per_px, exposure_s, expose_after_ticks, answer_latency_s, search_mm] = m.camera;
  rows.add(Row("camera").add(width_px).add(height_px).add(mm_per_px).add(search_mm));
  const auto& [axis, speed, approach, travel, retract, fast, back_off] = m.probe;
  rows.add(Row("probe")
               .add(axis.value < m.axes.size() ? m.axes[axis.value].name : std::string())
               .add(speed)
               .add(approach)
               .add(travel)
               .add(retract)
               .add(fast)
               .add(back_off));
  return rows.text();
}

Row row(const recipes::Dot& dot) {
  const auto& [id, at, material, location, height_mm, on, off_board] = dot;
  Row out("dot");
  out.add(id).add(at).add(material).add(height_mm).add(on).add(off_board);
  return out;
}

Row row(const recipes::Bead& bead) {
  const auto& [id, points, closed, corner_tolerance, material, location, kind, curve_mm, on, off_board] = bead;
  Row out("bead");
  out.add(id).add(kind).add(closed).add(corner_tolerance).add(material).add(curve_mm).add(on).add(off_board);
  for (const Vec3 p : points) out.add(p);
  return out;
}

Row row(const recipes::Material& material) {
  const auto& [name, speed, gap, open_lead, close_lead, dot_time, settle_time, retract, tolerance, gap_tolerance,
               speed_tolerance, flow_follows_speed, location, early_off, back_track, tail_lift, rejoin_within_s,
               start_dwell_s, override_max, min_speed, locations] = material;
  Row out("material");
  out.add(name);
  for (const double v :
       {speed, gap, open_lead, close_lead, dot_time, settle_time, retract, tolerance, gap_tolerance, speed_tolerance,
        early_off, back_track, tail_lift, rejoin_within_s, start_dwell_s, override_max, min_speed})
    out.add(v);
  return out.add(flow_follows_speed);
}

Row row(const recipes::Part& part, const char* word) {
  const auto& [name, at, size, rotation, fixture, location, underside, unread] = part;
  Row out(word);
  out.add(name).add(at).add(size).add(rotation).add(fixture).add(underside);
  return out;
}

/// Lists that are gone through in an order keep that; fills and files of points stand in the features as they came out.
std::string recipe_of(const recipes::Recipe& recipe) {
  const auto& [name, file, placement, order, board, parts, keep_out, marks, mark_rules, touches, touch_rules, materials,
               purge, features, fills, sources, sequence] = recipe;
  std::string out = Row("recipe").add(name).add(placement == recipes::Placement::Marks ? "marks" : "fixture").text();
  {
    const auto& [size, thickness, frame, at, clamp_margin, location, locations] = board;
    out += Row("board").add(size).add(thickness).add(frame).add(at).add(clamp_margin).text();
  }
  Set unordered;
  for (const recipes::Part& part : parts) unordered.add(row(part, "part"));
  for (const recipes::Part& zone : keep_out) unordered.add(row(zone, "keep_out"));
  for (const recipes::Material& material : materials) unordered.add(row(material));
  out += unordered.text();
  for (const recipes::MarkDef& mark : marks) {
    const auto& [id, at, diameter, bright, location] = mark;
    out += Row("mark").add(id).add(at).add(diameter).add(bright).text();
  }
  {
    const auto& [residual, shift, rotation, attempts, symmetric, locations] = mark_rules;
    out += Row("mark_rules").add(residual).add(shift).add(rotation).add(attempts).add(symmetric).text();
  }
  for (const recipes::TouchPoint& touch : touches) {
    const auto& [id, at, location] = touch;
    out += Row("touch").add(id).add(at).text();
  }
  {
    const auto& [residual, window, tilt, location] = touch_rules;
    Row rules("touch_rules");
    rules.add(residual).add(window);
    if (tilt) rules.add(*tilt);
    out += rules.text();
  }
  if (purge) {
    const auto& [material, frame, at, shots, after_s, location, material_location, frame_location, at_location] =
        *purge;
    out += Row("purge").add(material).add(frame).add(at).add(shots).add(after_s).text();
  }
  for (const std::size_t f : recipes::sequence_of(recipe))
    out += std::visit([](const auto& each) { return row(each).text(); }, features[f]);
  return out;
}

}  // namespace

ProofInputs proof_inputs(const config::Machine& machine, const recipes::Recipe& recipe) {
  return {hash_of("scene", scene_of(machine, recipe)), hash_of("head", head_of(machine)),
          hash_of("recipe", recipe_of(recipe)), hash_of("limits", limits_text(machine)),
          hash_of("calibration", calibration_of(machine))};
}

}  // namespace gantry::job
