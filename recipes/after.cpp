#include "recipes/after.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "core/near_word.hpp"

namespace gantry::recipes::written {
namespace {

using config::Mistakes;
using Rows = std::vector<std::vector<std::uint32_t>>;

/// Finds each circle once: by walks that go from a row to those that it waits for.
class Circles {
 public:
  Circles(const std::vector<FeatureRow>& rows, const Rows& before, Mistakes& mistakes)
      : rows_(rows), before_(before), mistakes_(mistakes), state_(rows.size(), State::New) {}

  void tell() {
    for (std::uint32_t row = 0; row < rows_.size(); ++row) walk_from(row);
  }

 private:
  enum class State : std::uint8_t { New, OnTheWalk, Done };
  struct Step {
    std::uint32_t row = 0;
    std::size_t next = 0;  ///< of the rows that it waits for
  };

  void walk_from(std::uint32_t start) {
    if (state_[start] != State::New) return;
    state_[start] = State::OnTheWalk;
    std::vector<Step> walk{{start}};
    while (!walk.empty()) {
      Step& here = walk.back();
      if (here.next == before_[here.row].size()) {
        state_[here.row] = State::Done;
        walk.pop_back();
        continue;
      }
      const std::uint32_t to = before_[here.row][here.next++];
      if (state_[to] == State::OnTheWalk) tell_circle(walk, to);
      if (state_[to] != State::New) continue;
      state_[to] = State::OnTheWalk;
      walk.push_back({to});
    }
  }

  void tell_circle(const std::vector<Step>& walk, std::uint32_t to) {
    constexpr std::size_t kShown = 6;
    const auto from = std::find_if(walk.begin(), walk.end(), [&](const Step& step) { return step.row == to; });
    const auto count = static_cast<std::size_t>(walk.end() - from);
    std::string words;
    for (std::size_t i = 0; i < count; ++i) {
      const auto& [row, next] = from[static_cast<std::ptrdiff_t>(i)];
      if (count > kShown && i + 1 == kShown) words += " and so on,";
      if (count > kShown && i + 1 >= kShown && i + 1 < count) continue;
      words += fmt::format("{}'{}' after '{}'",
                           i == 0           ? ""
                           : i + 1 == count ? " and "
                                            : ", ",
                           rows_[row].name.value, rows_[before_[row][next - 1]].name.value);
    }
    mistakes_.add(Fault::Inconsistent,
                  fmt::format("these wait for one another: {}; take one of these `after` away", words),
                  location_of(rows_[walk.back().row], rows_[to].name.value));
  }

  static Location location_of(const FeatureRow& row, std::string_view name) {
    return std::find_if(row.after.begin(), row.after.end(), [&](const auto& each) { return each.value == name; })
        ->location;
  }

  const std::vector<FeatureRow>& rows_;
  const Rows& before_;
  Mistakes& mistakes_;
  std::vector<State> state_;
};

}  // namespace

Rows rows_before(const std::vector<FeatureRow>& rows, Order order, bool all_read, Mistakes& mistakes) {
  std::unordered_map<std::string_view, std::uint32_t> named;
  for (std::uint32_t row = 0; row < rows.size(); ++row) named.emplace(rows[row].name.value, row);
  Rows before(rows.size());
  const bool nameless = std::any_of(rows.begin(), rows.end(), [](const FeatureRow& r) { return !r.name.given(); });
  for (std::uint32_t row = 0; row < rows.size(); ++row)
    for (const auto& [name, location] : rows[row].after) {
      const auto found = named.find(name);
      if (found == named.end()) {
        if (!all_read && nameless) continue;  // it may be that one
        std::vector<std::string_view> known;
        for (const FeatureRow& each : rows) known.push_back(each.name.value);
        mistakes.add(Fault::UnknownReference,
                     fmt::format("there is no feature '{}'; {}", name, did_you_mean(name, known)), location);
      } else if (found->second == row) {
        mistakes.add(Fault::Inconsistent, fmt::format("'{}' cannot come after itself; take this away", name), location);
      } else if (order == Order::File && found->second > row) {
        if (!all_read) continue;  // it may be the order that was not read
        mistakes.add(Fault::Inconsistent,
                     fmt::format("'{}' comes after '{}', which stands behind it in the file (line {}); put it behind "
                                 "that one, or write `order: shortest`",
                                 rows[row].name.value, name, rows[found->second].location.line),
                     location);
      } else if (std::find(before[row].begin(), before[row].end(), found->second) == before[row].end()) {
        before[row].push_back(found->second);
      }
    }
  if (order == Order::Shortest) Circles(rows, before, mistakes).tell();
  return before;
}

}  // namespace gantry::recipes::written
