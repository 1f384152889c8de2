// Parameters by whose value the program scales a motion, or takes 6064h for a measurement: what a profile's `drive`
// says of these must be what the parameter makes of it, and no machine file may state another value.
#pragma once
#include <algorithm>
#include <array>
#include <string_view>

namespace gantry::config {

struct StatedFact {
  std::string_view parameter;
  bool is_count;  ///< its value is the fact, unless `means` says otherwise; else it is a code
};
inline constexpr std::array kStatedFacts{StatedFact{"counts_per_rev", true}, StatedFact{"loop_mode", false},
                                         StatedFact{"motor_mode", false}};

/// nullptr: it states none.
constexpr const StatedFact* find_stated_fact(std::string_view parameter) {
  const auto* const at = std::ranges::find(kStatedFacts, parameter, &StatedFact::parameter);
  return at != kStatedFacts.end() ? at : nullptr;
}

}  // namespace gantry::config
