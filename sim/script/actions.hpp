// Everything that `do:` may say in a world script: one row for each word, with the keys that it takes.
#pragma once
#include <functional>
#include <string_view>
#include <vector>

#include "sim/script/names.hpp"
#include "sim/script/world_event.hpp"

namespace gantry::sim {

/// An entry as it is written.
struct Entry {
  config::At<std::string> at, act, axis, station, name, input;
  double after_s = 0, hold_s = 0.2, dark_s = 0.2, by_s = 0;
  config::At<int> drive;
  std::uint32_t code = 0, seed = 1;
  int count = 0, port = 0;
  bool on = false;
  double ppm = 0, value = 0, diameter = 0, grey = 30;
  config::At<config::ObjectAddress> object;
  LineNoise noise;
  Vec3 centre, size;
  Vec2 by;
};

struct ActionRow {
  std::string_view name;
  config::Fields<Entry> keys;
  std::function<Action(const Entry&, Names&)> make;
};
const std::vector<ActionRow>& actions();

Time time_of(double seconds);

}  // namespace gantry::sim
