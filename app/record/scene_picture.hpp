// What the report shows in three dimensions, as plain values: bodies, paths, and the poses of the head that are worth
// looking at. All lengths in mm, all points in the machine frame.
//   const ScenePicture picture = scene_picture(result);   if (!picture.bodies.empty()) page += to_json(picture);
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/record/job_result.hpp"
#include "app/record/tip_lines.hpp"

namespace gantry::record {

/// The head at a moment of the job.
struct ScenePose {
  std::string label, words;
  Vec3 head;                      ///< X Y Z of the axes
  double lift_mm = 0;             ///< U
  double turn_rad = 0;            ///< C
  std::string moving, standing;   ///< the two bodies that are near each other; empty: none are meant
  std::optional<Vec3> at;         ///< where they are, on the standing body
  bool meets = false;             ///< they collide, or would; else they are only near
  std::vector<Vec3> motion = {};  ///< of a motion that is refused: of the moving body's lower end
};

struct ScenePicture {
  std::vector<DrawnBody> bodies;
  Vec2 turn_axis;  ///< about which bodies of the head turn, in its frame
  std::vector<DrawnSpot> spots;
  TipLines lines;                ///< where the tips went
  TipLines asked;                ///< what was to be dispensed, where something of it is missing
  std::vector<ScenePose> poses;  ///< the one to begin with first
};

ScenePicture scene_picture(const JobResult& result);

/// For the page's script: {bodies, turn_axis, spots, travel, beads, dots, asked, poses}; what is no number is left out.
nlohmann::ordered_json to_json(const ScenePicture& picture);

}  // namespace gantry::record
