#include "sim/world/world_json.hpp"

#include <limits>
#include <nlohmann/json.hpp>

namespace gantry::sim {

using nlohmann::json;

namespace {

json to_json(Vec2 p) { return json::array({p.x, p.y}); }
json to_json(Vec3 p) { return json::array({p.x, p.y, p.z}); }
Vec2 vec2(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>()}; }
Vec3 vec3(const json& j) { return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()}; }

/// Worlds that were written before beads had heights hold two numbers.
Vec3 spot(const json& j) {
  return {j.at(0).get<double>(), j.at(1).get<double>(), j.size() > 2 ? j.at(2).get<double>() : 0};
}

/// JSON has no word for what is not a number but null.
double number(const json& j) { return j.is_null() ? std::numeric_limits<double>::quiet_NaN() : j.get<double>(); }

template <class Point>
json points(const std::vector<Point>& list) {
  json out = json::array();
  for (const Point& p : list) out.push_back(to_json(p));
  return out;
}
template <class Point, class Read>
std::vector<Point> points(const json& list, Read read) {
  std::vector<Point> out;
  for (const json& p : list) out.push_back(read(p));
  return out;
}

std::optional<Sag> sag_from_json(const json& j) {
  if (j.is_null()) return std::nullopt;
  return Sag{j.at(0).get<double>(), j.at(1).get<double>()};
}

std::optional<DepositSpeed> speed(const json& deposit) {
  const auto found = deposit.find("speed");
  if (found == deposit.end() || found->is_null()) return std::nullopt;
  const auto value = [&](std::size_t i) { return found->at(i).get<double>(); };
  return DepositSpeed{value(0),
                      value(1),
                      value(2),
                      value(3),
                      value(4),
                      value(5),
                      found->at(6).is_null() ? std::nullopt : std::optional(value(6)),
                      sag_from_json(found->at(7)),
                      value(8)};
}

/// nlohmann throws on a missing key or another type; that ends here.
template <class T, class Read>
Result<T> read(Read&& reader) {
  try {
    return reader();
  } catch (const json::exception& e) {
    return fail(Fault::BadValue, std::string("the world's JSON is not as expected: ") + e.what());
  }
}

}  // namespace

json to_json(const BoardPlan& plan) {
  const recipes::Board& b = plan.board;
  json out{
      {"name", plan.name},
      {"board", {{"size", to_json(b.size)}, {"thickness", b.thickness}, {"frame", b.frame}, {"at", to_json(b.at)}}},
      {"parts", json::array()},
      {"marks", json::array()},
      {"features", json::array()},
      {"touches", plan.touches}};
  if (plan.in_fixture) out["in_fixture"] = true;
  if (plan.purge) out["purge"] = {{"frame", plan.purge->frame}, {"at", to_json(plan.purge->at)}};
  for (const recipes::Part& p : plan.parts)
    out["parts"].push_back({{"name", p.name},
                            {"at", to_json(p.at)},
                            {"size", to_json(p.size)},
                            {"rotation", p.rotation},
                            {"fixture", p.fixture},
                            {"underside", p.underside}});
  for (const recipes::MarkDef& m : plan.marks)
    out["marks"].push_back({{"name", m.name}, {"at", to_json(m.at)}, {"diameter", m.diameter}, {"bright", m.bright}});
  for (const BoardPlan::Feature& f : plan.features)
    out["features"].push_back({{"id", f.id},
                               {"bead", f.bead},
                               {"points", points(f.points)},
                               {"gap", f.gap_mm},
                               {"speed", f.speed_mm_s},
                               {"speed_tolerance", f.speed_tolerance}});
  return out;
}

json to_json(const BoardPlacement& p) {
  return {{"shift", to_json(p.shift)}, {"rotation", p.rotation_rad}, {"z0", p.z0_mm}, {"slope", to_json(p.slope)}};
}

json to_json(const DepositSpeed& v) {
  return json::array({v.asked_mm_s, v.least_mm_s, v.most_mm_s, v.within_5_percent, v.volume_per_length,
                      v.within_tolerance, v.held_mm_s ? json(*v.held_mm_s) : json(nullptr),
                      v.sag ? json::array({v.sag->low_mm_s, v.sag->lasts_s}) : json(nullptr), v.stood_s});
}

json to_json(const Deposit& d) {
  return {{"id", d.id},
          {"kind", d.kind},
          {"nominal_mm", points(d.nominal_mm)},
          {"board_mm", points(d.board_mm)},
          {"error_mm", d.error_mm},
          {"gap_mm", d.gap_mm},
          {"asked_gap_mm", d.asked_gap_mm},
          {"opened_cycle", d.opened_cycle},
          {"closed_cycle", d.closed_cycle},
          {"joins_mm", d.joins_mm},
          {"speed", d.speed ? to_json(*d.speed) : json(nullptr)},
          {"open_s", d.open_s}};
}

json to_json(const Collision& c) {
  return {{"moving", c.moving}, {"standing", c.standing}, {"at", to_json(c.at)}, {"cycle", c.cycle}, {"t_s", c.t_s}};
}

Result<BoardPlan> plan_from_json(const json& j) {
  return read<BoardPlan>([&] {
    BoardPlan plan;
    j.at("name").get_to(plan.name);
    const json& b = j.at("board");
    plan.board.size = vec2(b.at("size"));
    b.at("thickness").get_to(plan.board.thickness);
    b.at("frame").get_to(plan.board.frame);
    plan.board.at = vec2(b.at("at"));
    for (const json& p : j.at("parts"))
      plan.parts.push_back({p.at("name"),
                            vec2(p.at("at")),
                            vec3(p.at("size")),
                            p.at("rotation"),
                            p.at("fixture"),
                            {},
                            p.value("underside", 0.0)});
    for (const json& m : j.at("marks"))
      plan.marks.push_back({m.at("name"), vec2(m.at("at")), m.at("diameter"), m.at("bright"), {}});
    for (const json& f : j.at("features"))
      plan.features.push_back({f.at("id"), f.at("bead"), points<Vec3>(f.at("points"), spot), f.at("gap"),
                               f.value("speed", 0.0), f.value("speed_tolerance", recipes::Material{}.speed_tolerance)});
    plan.touches = j.value("touches", std::size_t{0});
    plan.in_fixture = j.value("in_fixture", false);
    if (const auto purge = j.find("purge"); purge != j.end()) {
      plan.purge.emplace();
      purge->at("frame").get_to(plan.purge->frame);
      plan.purge->at = vec3(purge->at("at"));
    }
    return plan;
  });
}

Result<BoardPlacement> placement_from_json(const json& j) {
  return read<BoardPlacement>([&] {
    return BoardPlacement{vec2(j.at("shift")), j.at("rotation"), j.at("z0"), vec2(j.at("slope"))};
  });
}

Result<Deposit> deposit_from_json(const json& j) {
  return read<Deposit>([&] {
    return Deposit{j.at("id"),
                   j.at("kind"),
                   points<Vec3>(j.at("nominal_mm"), vec3),
                   points<Vec3>(j.at("board_mm"), vec3),
                   number(j.at("error_mm")),
                   j.at("gap_mm"),
                   number(j.at("asked_gap_mm")),
                   j.at("opened_cycle"),
                   j.at("closed_cycle"),
                   j.at("joins_mm"),
                   speed(j),
                   j.value("open_s", 0.0)};
  });
}

Result<Collision> collision_from_json(const json& j) {
  return read<Collision>([&] {
    return Collision{j.at("moving"), j.at("standing"), vec3(j.at("at")), j.at("cycle"), j.at("t_s")};
  });
}

Result<json> parse_json(std::string_view text) {
  json j = json::parse(text, nullptr, false);
  if (j.is_discarded()) return fail(Fault::BadValue, "not well-formed JSON");
  return j;
}

}  // namespace gantry::sim
