// How many lines a log takes: a burst, then one now and again; what is left out is counted. Whoever makes us write (a
// flood from the network) fills no disk.
//   LineLimit limit;
//   if (limit.admit(now)) log::warn("{}{}", text, limit.left_out_words());
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>

#include "core/clean_text.hpp"
#include "core/clock.hpp"

namespace gantry::monitor {

class LineLimit {
 public:
  static constexpr int kBurst = 20;                         ///< lines at once
  static constexpr Time kPause = std::chrono::seconds(10);  ///< after which one more may come
  static constexpr std::size_t kLongest = 300;              ///< bytes of a line, see printable()

  /// `now` of a clock that does not jump.
  bool admit(Time now) {
    if (now - refilled_ >= kPause) {
      const auto more = (now - refilled_) / kPause;
      left_ = static_cast<int>(std::min<std::int64_t>(kBurst, left_ + more));
      refilled_ += more * kPause;
    }
    if (left_ == 0) return ++left_out_, false;
    --left_;
    return true;
  }

  /// "", or " (1234 more lines were left out)" and counts anew.
  std::string left_out_words() {
    if (left_out_ == 0) return {};
    return " (" + std::to_string(std::exchange(left_out_, 0)) + " more lines were left out)";
  }

 private:
  int left_ = kBurst;
  Time refilled_{0};
  std::uint64_t left_out_ = 0;
};

/// One line of bounded length in which nothing steers a terminal: for text that comes from elsewhere.
inline std::string printable(std::string_view text) {
  while (!text.empty() && text.back() == '\n') text.remove_suffix(1);
  std::string line = clean_text(text.substr(0, LineLimit::kLongest));
  std::size_t end = std::min(line.size(), LineLimit::kLongest);
  while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xC0u) == 0x80u) --end;  // between characters
  line.resize(end);
  return line;
}

}  // namespace gantry::monitor
