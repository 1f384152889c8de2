// Which features come before which, whatever is shorter: what a recipe says with `after`, and features of different
// materials that come near to each other, because the later one may lie on the earlier one. Those keep the order of the
// file, where `after` does not turn it round.
//   Precedence before = by_rows(rows_before, row_of);   keep_layers(recipe, before);
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "core/error.hpp"
#include "recipes/recipe.hpp"

namespace gantry::recipes {

/// No chain of it leads back to where it began, and in_rows() keeps all of it.
struct Precedence {
  std::vector<std::uint32_t> row;  ///< of each feature: where it is written; features of a row are neighbours
  std::vector<std::vector<std::uint32_t>> rows;      ///< of each row: the rows that are done before it
  std::vector<std::vector<std::uint32_t>> features;  ///< of each feature: others that are done before it
  [[nodiscard]] bool none() const;
};

/// `after`: of each row those that it waits for, without a circle; `row_of`: the row of each feature.
Precedence by_rows(std::vector<std::vector<std::uint32_t>> after, std::vector<std::uint32_t> row_of);

/// Which features may come next, while others come one after the other.
class MayCome {
 public:
  explicit MayCome(const Precedence& before);
  /// It waits for none that has not come.
  [[nodiscard]] bool is_free(std::uint32_t feature) const { return waits_[feature] == 0; }
  /// One that was free comes; `freed` is overwritten with those that are free by that.
  void came(std::uint32_t feature, std::vector<std::uint32_t>& freed);

 private:
  void row_came(std::uint32_t row, std::vector<std::uint32_t>& freed);
  void one_less(std::uint32_t feature, std::vector<std::uint32_t>& freed);

  std::vector<std::uint32_t> row_;
  std::vector<std::vector<std::uint32_t>> in_row_, rows_behind_;  ///< of each row: its features; rows that wait for it
  std::vector<std::vector<std::uint32_t>> behind_;                ///< of each feature: those that wait for it alone
  std::vector<std::size_t> waits_, left_, row_waits_;
};

/// The order of the file, with as few rows later as `after` asks for.
std::vector<std::size_t> in_rows(const Precedence& before);

/// Adds the layers: features of two materials that are nearer to each other than this, seen from above.
inline constexpr double kLayer_mm = 1;
/// Fault::TooManySteps: there are more such pairs than are kept.
Result<void> keep_layers(const Recipe& recipe, Precedence& before);

}  // namespace gantry::recipes
