// Rules that the rows of a profile keep among themselves: what stands twice, what two rows say otherwise of one thing,
// what no station can have. One table of them; each tells the place of the row and what to write instead.
//   keep_profile_rules(profile, root, mistakes);
#pragma once
#include "config/drive.hpp"
#include "config/yaml.hpp"

namespace gantry::config {

/// `root`: the file whose rows `profile` was read from without a mistake.
void keep_profile_rules(const StationProfile& profile, const Node& root, Mistakes& mistakes);

/// The place of a row's key, else the row's.
Location location_of_key(const Node& row, std::string_view key);

}  // namespace gantry::config
