// What the profile of a station says against itself: facts of its drive against the rows that state them, entries
// without which no loop runs, process data that lie over each other.
//   read_object(*root, profile_fields(), profile, ...);   check_profile(profile, *root, mistakes);
#pragma once
#include <cstdint>
#include <optional>

#include "config/drive.hpp"
#include "config/fields.hpp"

namespace gantry::config {

/// Facts of the drive that a parameter's value stands for, where it is a code and no number.
struct Meaning {
  std::optional<std::int64_t> counts_per_rev;
  std::optional<bool> closed_loop;
};
const Fields<Meaning>& meaning_fields();

/// `root`: the file whose rows `profile` was read from without a mistake.
void check_profile(const StationProfile& profile, const Node& root, Mistakes& mistakes);

}  // namespace gantry::config
