#include "core/near_word.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <numeric>

namespace gantry {

std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known) {
  std::string_view best;
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  for (const std::string_view candidate : known)
    if (candidate.size() == 3 && slip_of(word, candidate)) return candidate;                 // "gpa", and "gap"
  std::size_t best_distance = 1 + std::max<std::size_t>(letters <= 3 ? 1 : 2, letters / 3);  // "foo" is no "jog"
  if (word.size() > 100) return best;
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  for (const std::string_view candidate : known)
    if (candidate != word && std::equal(word.begin(), word.end(), candidate.begin(), candidate.end(),
                                        [&](char a, char b) { return lower(a) == lower(b); }))
      return candidate;
  for (const std::string_view candidate : known) {
    // Levenshtein, one row at a time.
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t replaced = diagonal + (word[i] == candidate[j] ? 0 : 1);
        diagonal = row[j + 1];
        row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
      }
    }
    if (row.back() < best_distance && row.back() < candidate.size()) best_distance = row.back(), best = candidate;
  }
  return best;
}

bool slip_of(std::string_view word, std::string_view known) {
  constexpr std::size_t kShort = 5, kLongest = 100;
  const std::size_t most = known.size() <= kShort ? 1 : 2;
  if (word == known || word.size() > known.size() + most || word.size() + most < known.size() ||
      known.size() > kLongest)
    return false;
  // Optimal string alignment: as Levenshtein, and two neighbours changed over are one slip.
  std::vector<std::vector<std::size_t>> d(word.size() + 1, std::vector<std::size_t>(known.size() + 1));
  for (std::size_t i = 0; i <= word.size(); ++i)
    for (std::size_t j = 0; j <= known.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (word[i - 1] == known[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && word[i - 1] == known[j - 2] && word[i - 2] == known[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[word.size()][known.size()] <= most;
}

std::string did_you_mean(std::string_view known) { return fmt::format("did you mean '{}'?", known); }

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& known, std::string otherwise) {
  const std::string_view near = nearest(word, known);
  return near.empty() ? std::move(otherwise) : did_you_mean(near);
}

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& known) {
  constexpr std::size_t kListed = 20;
  if (known.empty()) return "there are none";
  const auto last = known.begin() + static_cast<std::ptrdiff_t>(std::min(known.size(), kListed));
  return did_you_mean(
      word, known,
      fmt::format("known: {}{}", fmt::join(known.begin(), last, ", "), known.size() > kListed ? ", ..." : ""));
}

}  // namespace gantry
