// How many lines a log takes: a burst, then one now and again; what is left out is counted. Whoever makes us write (a
// flood from the network) fills no disk.
//   LineLimit limit;
//   if (limit.admit(now)) log::warn("{}{}", text, limit.left_out_words());
#pragma once
#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

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
inline std::string printable(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  if (text.size() > LineLimit::kLongest) text.resize(LineLimit::kLongest);
  for (auto& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return text;
}

}  // namespace gantry::monitor
