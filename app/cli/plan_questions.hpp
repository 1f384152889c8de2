// The questions of `gantry plan`, as they stand in their JSON files, and the answers.
//   auto queries = read_queries("queries.json");   auto rows = answer_queries(scene, clearance_mm, *queries);
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"
#include "motion/plan/scene.hpp"

namespace gantry::cli {

/// From one position of the tip to another. `id`: a text or a whole number, given back as it came.
struct Question {
  nlohmann::ordered_json id;
  Vec3 from, to;
};

/// [{id, start: [x, y, z], goal: [x, y, z]}]; every mistake with its location (Fault 4xx).
Checked<std::vector<Question>> read_queries(const std::string& path);
/// [{id, from: [x, y, z], to: [x, y, z]}]
Checked<std::vector<Question>> read_motions(const std::string& path);

/// Paths: {id, status, closed_in, path, length_mm, min_clearance_mm, pair, point, plan_us}.
nlohmann::ordered_json answer_queries(const motion::Scene& scene, double clearance_mm,
                                      const std::vector<Question>& queries);
/// Straight motions: {id, free, pair, t, point, distance_mm, check_us}.
nlohmann::ordered_json answer_motions(const motion::Scene& scene, double clearance_mm,
                                      const std::vector<Question>& motions);

}  // namespace gantry::cli
