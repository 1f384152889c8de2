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
    Note note;                ///< the newest
    int count = 1;            ///< so often it came since it was last told
    std::int64_t age_ns = 0;  ///< since the newest came
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
    kept.note = std::move(note), kept.came_ns = now_ns;
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

  /// All that is held back, and every note is new again: another job begins or ends.
  std::vector<Told> flush(std::int64_t now_ns) {
    std::vector<Told> list;
    for (auto& [key, kept] : kept_)
      if (kept.held_back > 0) list.push_back({std::move(kept.note), kept.held_back, now_ns - kept.came_ns});
    kept_.clear();
    return list;
  }

 private:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  static constexpr std::int64_t kShortest_ns = kSecond_ns;
  static constexpr std::int64_t kForgotten_ns = 60 * kSecond_ns;  // of quiet: the next one is told at once

  struct Kept {
    Note note{};
    std::int64_t told_ns = 0, came_ns = 0, pause_ns = 0;
    int held_back = 0;  ///< since then
  };

  std::optional<Told> told_if_due(Kept& kept, std::int64_t now_ns) const {
    if (now_ns - kept.told_ns < kept.pause_ns) return std::nullopt;
    kept.told_ns = now_ns;
    kept.pause_ns = std::min(2 * kept.pause_ns, longest_ns_);
    return Told{std::move(kept.note), std::exchange(kept.held_back, 0), now_ns - kept.came_ns};
  }

  std::int64_t longest_ns_;
  std::map<Key, Kept> kept_;
};

/// "", or ", 3.2 s ago (12 more times since it was last told)".
inline std::string again(int count, std::int64_t age_ns = 0) {
  constexpr std::int64_t kTenth_ns = 100'000'000, kNow_ns = 5 * kTenth_ns;
  const std::int64_t tenths = (age_ns + kTenth_ns / 2) / kTenth_ns;
  const std::string ago =
      age_ns < kNow_ns ? "" : ", " + std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " s ago";
  return ago + (count > 1 ? " (" + std::to_string(count - 1) + " more times since it was last told)" : "");
}

}  // namespace gantry::stations
