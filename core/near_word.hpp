// "Did you mean ...?": what a message says of a name that nobody knows. One choice of words for the whole program.
//   fail(Fault::UnknownReference, fmt::format("there is no axis '{}'; {}", name, did_you_mean(name, names)));
#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace gantry {

/// The known word nearest to `word` by edit distance, first that with other capitals; empty when none is near enough to
/// be meant.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& known);

/// Whether `word` is likely to be `known` with a slip of the pen: one letter more, less, another, or two changed over;
/// two such slips in words of six letters and more. Much stricter than nearest(): for words that may well be meant.
bool slip_of(std::string_view word, std::string_view known);

/// "did you mean 'speed'?", of a word that was chosen.
std::string did_you_mean(std::string_view known);
/// The same of the nearest of them; where no word is near, `otherwise`.
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& known, std::string otherwise);
/// The same, otherwise "known: speed, gap" (the first twenty), or "there are none".
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& known);

}  // namespace gantry
