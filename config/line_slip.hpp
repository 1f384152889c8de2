// One line that begins in the wrong column, or is not there, makes a dozen mistakes of a file that is well-formed YAML
// all the same: its neighbours belong to something else then. And of one that is not well-formed the parser tells where
// it stopped, not where its writer slipped. So it is tried out: a line is moved, a sign is left out, a line is put in
// (line_trials.hpp), and the file is read again; where that leaves nothing but what was wrong before, or next to
// nothing, and everything in it is still read, that line is the mistake.
//   Mistakes mistakes = judge(text);   // one instead of many:
//   if (const auto slip = find_line_slip(text, mistakes, format, judge)) mistakes = slip->left;
#pragma once
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "config/yaml.hpp"

namespace gantry::config {

struct FieldShape;

struct LineSlip {
  Mistakes left;  ///< the slip, and what is wrong besides
  /// The text with the line where it belongs; none where a line is missing, whose words only its writer knows.
  std::optional<std::string> mended;
};

/// told: what judge(text) is. format: the keys at the top of the file. Reads the text some hundred times, 2 MB in all
/// at most.
std::optional<LineSlip> find_line_slip(std::string_view text, const Mistakes& told, std::span<const FieldShape> format,
                                       const std::function<Mistakes(std::string_view)>& judge);

}  // namespace gantry::config
