// Words in a picture, none upon another. What is drawn for a wide page is too small on a phone: the same words are put
// once for each, in letters that can be read there, and the style sheet shows one of them.
//   Labels labels(svg, Labels::Page::Phone);   labels.put(at, "7", "order");      // left out where no room is left
#pragma once
#include <string_view>
#include <vector>

#include "app/record/svg.hpp"

namespace gantry::record {

class Labels {
 public:
  enum class Page { Wide, Phone };
  /// Of a picture that is 1000 wide, and on a phone shown at about a third of that.
  static constexpr double letters_px(Page page) { return page == Page::Wide ? 10 : 32; }

  /// Until it goes, all that is drawn is shown on such a page alone.
  Labels(Svg& svg, Page page) : svg_(svg), height_(letters_px(page)) {
    svg_.begin_group(page == Page::Wide ? "wide" : "narrow");
  }
  ~Labels() { svg_.end_group(); }
  Labels(const Labels&) = delete;
  Labels& operator=(const Labels&) = delete;

  [[nodiscard]] double width(std::string_view words) const {
    return 0.56 * height_ * static_cast<double>(words.size());
  }
  /// False: no room is left there. `anchor`: "start" or "middle", where `at` is of the words' base line.
  bool put(Vec2 at, std::string_view words, std::string_view css, std::string_view anchor = "start") {
    const double left = anchor == "middle" ? at.x - width(words) / 2 : at.x;
    const Box box{left, at.y - height_, left + width(words), at.y + 0.2 * height_};
    for (const Box& other : taken_)
      if (box.left < other.right && other.left < box.right && box.top < other.bottom && other.top < box.bottom)
        return false;
    taken_.push_back(box);
    svg_.words(at, words, css, anchor);
    return true;
  }

 private:
  struct Box {
    double left, top, right, bottom;
  };
  Svg& svg_;
  double height_;
  std::vector<Box> taken_;
};

}  // namespace gantry::record
