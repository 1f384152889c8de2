#include "app/record/scene_picture.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "core/meeting.hpp"

namespace gantry::record {
namespace {

constexpr std::size_t kMostCollisions = 10;  // poses of the same kind

bool finite(Vec3 p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

Vec3 head_at(const Drawing& d, const AxisVec& q) { return {q[d.xyz[0]], q[d.xyz[1]], q[d.xyz[2]]}; }
double lift_at(const Drawing& d, const AxisVec& q) { return d.lift ? q[*d.lift] : 0; }
double turn_at(const Drawing& d, const AxisVec& q) { return d.turn ? q[*d.turn] : 0; }

/// Of a body of the head, relative to the head's X Y Z.
Vec3 lower_end(const Drawing& d, const std::string& name, double lift_mm, double turn_rad) {
  for (const DrawnBody& b : d.bodies)
    if (b.role == DrawnBody::Role::Head && b.body.name == name) {
      const Vec2 from_axis = flat(b.body.centre) - d.turn_axis;
      const Vec2 at = b.body.on_turn ? d.turn_axis + rotated(from_axis, turn_rad) : flat(b.body.centre);
      return {at.x, at.y, b.body.centre.z - b.body.shape.size.z / 2 - (b.body.on_lift ? lift_mm : 0)};
    }
  return {};
}

ScenePose pose_of(const Drawing& d, const Error& e) {
  const Meeting& m = *e.meeting;
  ScenePose pose{"where they would collide",
                 fmt::format("{} would come nearer than {:.3g} mm to {}{}", m.head, m.clearance_mm, m.standing,
                             e.where.empty() ? "" : ": " + e.where),
                 head_at(d, m.axes),
                 lift_at(d, m.axes),
                 turn_at(d, m.axes),
                 m.head,
                 m.standing,
                 m.machine_mm,
                 true};
  if (m.from != m.to)
    for (const AxisVec* q : {&m.from, &m.to})
      pose.motion.push_back(head_at(d, *q) + lower_end(d, m.head, lift_at(d, *q), turn_at(d, *q)));
  return pose;
}

ScenePose pose_of(const JobResult& r, const Collision& c) {
  ScenePose pose{fmt::format("collision at {:.3f} s", c.t_s),
                 fmt::format("{} met {} at {:.3f} s", c.moving, c.standing, c.t_s),
                 {},
                 0,
                 0,
                 c.moving,
                 c.standing,
                 c.at,
                 true};
  const auto later = std::find_if(r.actual.begin(), r.actual.end(), [&](const auto& p) { return p.t_s >= c.t_s; });
  if (later != r.actual.end()) pose.head = later->head, pose.lift_mm = later->lift_mm, pose.turn_rad = later->turn_rad;
  return pose;
}

std::optional<ScenePose> pose_of(const Drawing& d, const std::optional<job::Nearest>& nearest, const char* label) {
  if (!nearest || !std::isfinite(nearest->distance_mm)) return std::nullopt;
  return ScenePose{label,
                   job::to_text(nearest),
                   head_at(d, nearest->axes),
                   lift_at(d, nearest->axes),
                   turn_at(d, nearest->axes),
                   nearest->head,
                   nearest->standing,
                   nearest->machine_mm};
}

std::vector<ScenePose> poses_of(const JobResult& r) {
  const Drawing& d = r.drawing;
  std::vector<ScenePose> poses;
  for (const Error& e : r.errors)
    if (e.meeting != nullptr) poses.push_back(pose_of(d, e));
  for (std::size_t i = 0; i < std::min(r.collisions.size(), kMostCollisions); ++i)
    poses.push_back(pose_of(r, r.collisions[i]));
  if (auto near = pose_of(d, r.minimum_clearance.others,
                          r.errors.empty() ? "the tightest place" : "the tightest place of what was proved"))
    poses.push_back(std::move(*near));
  if (auto near = pose_of(d, r.minimum_clearance.by_design, "the nearest by design")) poses.push_back(std::move(*near));
  if (!r.actual.empty())
    poses.push_back({"where the job ended", "", r.actual.back().head, r.actual.back().lift_mm, r.actual.back().turn_rad,
                     "", "", std::nullopt});
  if (poses.empty()) poses.push_back({"parked", "", d.park, 0, d.park_turn_rad, "", "", std::nullopt});
  std::erase_if(poses, [](const ScenePose& p) {
    return !finite(p.head) || !std::isfinite(p.lift_mm) || !std::isfinite(p.turn_rad);
  });
  return poses;
}

using Json = nlohmann::ordered_json;

double rounded(double mm) { return std::round(mm * 1000) / 1000; }
Json to_json(Vec3 p) { return Json::array({rounded(p.x), rounded(p.y), rounded(p.z)}); }

/// x, y, z, x, y, z, ...
Json to_json(const std::vector<Vec3>& points) {
  Json out = Json::array();
  for (const Vec3 p : points)
    for (const double v : {p.x, p.y, p.z}) out.push_back(rounded(v));
  return out;
}
Json to_json(const std::vector<std::vector<Vec3>>& lines) {
  Json out = Json::array();
  for (const auto& line : lines) out.push_back(to_json(line));
  return out;
}

const char* name(DrawnBody::Role role) {
  static constexpr const char* kNames[] = {"machine", "board", "part", "fixture", "head", "zone"};
  return kNames[static_cast<std::size_t>(role)];
}
const char* name(config::Shape::Kind kind) {
  static constexpr const char* kNames[] = {"box", "cylinder", "capsule"};
  return kNames[static_cast<std::size_t>(kind)];
}

Json to_json(const DrawnBody& b) {
  return {{"name", b.body.name},
          {"role", name(b.role)},
          {"kind", name(b.body.shape.kind)},
          {"centre", to_json(b.body.centre)},
          {"size", to_json(b.body.shape.size)},
          {"yaw", b.body.rotation_rad},
          {"on_lift", b.body.on_lift},
          {"on_turn", b.body.on_turn}};
}

Json to_json(const ScenePose& p) {
  Json j = {{"label", p.label},   {"words", p.words},   {"head", to_json(p.head)}, {"lift", p.lift_mm},
            {"turn", p.turn_rad}, {"moving", p.moving}, {"standing", p.standing},  {"meets", p.meets}};
  j["at"] = p.at && finite(*p.at) ? to_json(*p.at) : Json(nullptr);
  j["motion"] = to_json(p.motion);
  return j;
}

}  // namespace

ScenePicture scene_picture(const JobResult& r) {
  ScenePicture picture{r.drawing.bodies, r.drawing.turn_axis, r.drawing.spots, tip_lines(r), {}, poses_of(r)};
  if (r.features_done < r.features_total) picture.asked = asked_lines(r);
  return picture;
}

Json to_json(const ScenePicture& picture) {
  Json j = {{"bodies", Json::array()},
            {"turn_axis", {rounded(picture.turn_axis.x), rounded(picture.turn_axis.y)}},
            {"spots", Json::array()},
            {"poses", Json::array()}};
  for (const DrawnBody& b : picture.bodies)
    if (finite(b.body.centre) && finite(b.body.shape.size) && std::isfinite(b.body.rotation_rad))
      j["bodies"].push_back(to_json(b));
  for (const DrawnSpot& s : picture.spots)
    if (finite(s.at)) j["spots"].push_back({{"name", s.name}, {"at", to_json(s.at)}, {"touch", s.touch}});
  for (const ScenePose& p : picture.poses) j["poses"].push_back(to_json(p));
  j["travel"] = to_json(picture.lines.travel);
  j["beads"] = to_json(picture.lines.beads);
  j["dots"] = to_json(picture.lines.dots);
  j["asked"] = {{"beads", to_json(picture.asked.beads)}, {"dots", to_json(picture.asked.dots)}};
  return j;
}

}  // namespace gantry::record
