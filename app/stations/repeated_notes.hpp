// Keeps a note that comes again and again from filling the log: it is told once a second, with how often it came.
//   if (const auto words = notes.tell({fault, station}, now_ns, text)) log::warn("{}", *words);
#pragma once
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "core/fault.hpp"

namespace gantry::stations {

class RepeatedNotes {
 public:
  /// What counts as the same note: `of` tells stations or axes apart.
  struct Key {
    Fault fault{};
    int of = -1;
    auto operator<=>(const Key&) const = default;
  };
  /// `text`, with the count of those held back since; nothing while the same note was told less than a second ago.
  std::optional<std::string> tell(Key key, std::int64_t now_ns, std::string text) {
    constexpr std::int64_t kQuiet_ns = 1'000'000'000;
    Told& told = told_[key];
    if (told.count > 0 && now_ns - told.at_ns < kQuiet_ns) {
      ++told.count;
      return std::nullopt;
    }
    if (told.count > 1) text += " (" + std::to_string(told.count - 1) + " more times since it was last told)";
    told = {now_ns, 1};
    return text;
  }

 private:
  struct Told {
    std::int64_t at_ns = 0;
    int count = 0;  ///< since then, with that one
  };
  std::map<Key, Told> told_;
};

}  // namespace gantry::stations
