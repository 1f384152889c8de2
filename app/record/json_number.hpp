// A number as the JSON files of a job have it.
#pragma once
#include <cmath>
#include <nlohmann/json.hpp>

namespace gantry::record {

/// To a nanometre (or ns): the digits behind are the arithmetic's, and triple the size of a file. What is no number is
/// null.
inline nlohmann::ordered_json number(double v) {
  return std::isfinite(v) ? nlohmann::ordered_json(std::round(v * 1e6) / 1e6 + 0.0) : nlohmann::ordered_json(nullptr);
}

}  // namespace gantry::record
