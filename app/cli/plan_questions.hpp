// The questions of `gantry plan`, as they stand in their JSON files, and the answers.
//   auto queries = read_queries("queries.json", Turns::No);   auto rows = answer_queries(scene, clearance_mm,
//   *queries);
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/vec.hpp"
#include "motion/plan/scene.hpp"

namespace gantry::cli {

/// Of the tip, and how C stands.
struct Position {
  Vec3 tip;
  double c_deg = 0;
};
/// From one position to another. `id`: a text or a whole number, given back as it came.
struct Question {
  nlohmann::ordered_json id;
  Position from, to;
};

/// Whether a position may tell C: [x, y, z, c].
enum class Turns : std::uint8_t { No, Yes };

/// [{id, start: [x, y, z], goal: [x, y, z]}]; every mistake with its location (Fault 4xx).
Checked<std::vector<Question>> read_queries(const std::string& path, Turns turns);
/// [{id, from: [x, y, z], to: [x, y, z]}]
Checked<std::vector<Question>> read_motions(const std::string& path, Turns turns);

/// Paths: {id, status, closed_in, path, length_mm, min_clearance_mm, pair, point, plan_us}. Where C is among the axes
/// of the scene it is the fourth, and each position of a path has four numbers.
nlohmann::ordered_json answer_queries(const motion::Scene& scene, double clearance_mm,
                                      const std::vector<Question>& queries);
/// Straight motions: {id, free, pair, t, point, distance_mm, check_us}.
nlohmann::ordered_json answer_motions(const motion::Scene& scene, double clearance_mm,
                                      const std::vector<Question>& motions);

}  // namespace gantry::cli
