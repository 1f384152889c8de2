// Keeps a note that comes again and again from filling log and events: it is told at once, then after 1 s, 2 s, 4 s ...
// up to a longest pause, with how often it came. None is lost: the counts of all that is told make up all that came.
//   RepeatedNotes<std::string> notes;
//   if (const auto told = notes.tell({fault, station}, now_ns, text)) log::warn("{}{}", told->note,
//   again(told->count)); each step: for (const auto& told : notes.due(now_ns)) ...     // held back, and its pause is
//   over
#pragma once
#include <algorithm>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/fault.hpp"

namespace gantry::stations {

template <class Note>
class RepeatedNotes {
 public:
  /// What counts as the same note: `of` tells stations or axes apart.
  struct Key {
    Fault fault{};
    int of = -1;
    auto operator<=>(const Key&) const = default;
  };
  struct Told {
    Note note;      ///< the newest
    int count = 1;  ///< so often it came since it was last told
  };

  explicit RepeatedNotes(int longest_pause_s = 30) : longest_ns_(longest_pause_s * kSecond_ns) {}

  /// Nothing while the pause since it was last told lasts.
  std::optional<Told> tell(Key key, std::int64_t now_ns, Note note) {
    const auto [at, first] = kept_.try_emplace(key);
    Kept& kept = at->second;
    if (first || now_ns - kept.told_ns >= kForgotten_ns) {
      const int count = std::exchange(kept.held_back, 0) + 1;
      kept.told_ns = now_ns, kept.pause_ns = kShortest_ns;
      return Told{std::move(note), count};
    }
    kept.note = std::move(note);
    ++kept.held_back;
    return told_if_due(kept, now_ns);
  }

  std::vector<Told> due(std::int64_t now_ns) {
    std::vector<Told> list;
    for (auto& [key, kept] : kept_)
      if (kept.held_back > 0)
        if (auto told = told_if_due(kept, now_ns)) list.push_back(std::move(*told));
    return list;
  }

 private:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  static constexpr std::int64_t kShortest_ns = kSecond_ns;
  static constexpr std::int64_t kForgotten_ns = 60 * kSecond_ns;  // of quiet: the next one is told at once

  struct Kept {
    Note note{};
    std::int64_t told_ns = 0, pause_ns = 0;
    int held_back = 0;  ///< since then
  };

  std::optional<Told> told_if_due(Kept& kept, std::int64_t now_ns) const {
    if (now_ns - kept.told_ns < kept.pause_ns) return std::nullopt;
    kept.told_ns = now_ns;
    kept.pause_ns = std::min(2 * kept.pause_ns, longest_ns_);
    return Told{std::move(kept.note), std::exchange(kept.held_back, 0)};
  }

  std::int64_t longest_ns_;
  std::map<Key, Kept> kept_;
};

/// "", or " (12 more times since it was last told)".
inline std::string again(int count) {
  return count > 1 ? " (" + std::to_string(count - 1) + " more times since it was last told)" : "";
}

}  // namespace gantry::stations
