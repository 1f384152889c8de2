// Machines for tests of the bus: a few stations with the shipped profiles and axes whose truth the test knows.
#pragma once
#include <stdexcept>
#include <string>

#include "config/machine.hpp"

namespace gantry::sim::test {

inline config::StationProfile profile(const std::string& file) {
  auto loaded = config::load_profile(std::string(GANTRY_SOURCE_DIR "/config/") + file);
  if (!loaded) throw std::runtime_error(to_text(loaded.error().front()));
  return std::move(*loaded);
}

inline void add_station(config::Machine& m, const std::string& file) {
  config::Station s;
  s.id = StationId{static_cast<std::uint16_t>(m.stations.size())};
  s.position = static_cast<int>(m.stations.size());
  s.alias = static_cast<std::uint16_t>(100 + s.position);
  s.profile = profile(file);
  s.name = s.profile.name;
  m.stations.push_back(std::move(s));
}

/// 2000 counts/mm, switches at -10, 0 (home, closed below) and 500, lag 4 ms, standing at 50.
inline void add_axis(config::Machine& m, std::uint16_t station, int slot = 0, bool invert = false) {
  config::Axis a;
  a.id = AxisId{static_cast<std::uint8_t>(m.axes.size())};
  a.drives = {{StationId{station}, slot, invert}};
  a.unit_per_rev = 5;
  a.counts_per_unit = 2000;
  m.axes.push_back(a);
  config::SimAxis truth;
  truth.lag_s = 0.004;
  truth.neg_limit = -10, truth.pos_limit = 500, truth.home_switch = 0, truth.home_active_below = true;
  truth.start = 50;
  m.sim.axes.push_back(truth);
}

/// The six EtherCAT stations of the reference machine's kinds: iD286 x2, AMD530B x2 (one gantry axis), STD402EC, I/O.
inline config::Machine reference() {
  config::Machine m;
  add_station(m, "drives/id286.yaml");
  add_station(m, "drives/amd530b.yaml");
  add_station(m, "drives/amd530b.yaml");
  add_station(m, "drives/id286.yaml");
  add_station(m, "drives/std402ec.yaml");
  add_station(m, "devices/dio16.yaml");
  add_axis(m, 0);
  add_axis(m, 1);
  m.axes.back().drives.push_back({StationId{2}, 0, true});
  add_axis(m, 3);
  add_axis(m, 4, 0);
  add_axis(m, 4, 1);
  return m;
}

inline config::Machine one(const std::string& file, int axes = 1) {
  config::Machine m;
  add_station(m, file);
  for (int i = 0; i < axes; ++i) add_axis(m, 0, i);
  return m;
}

}  // namespace gantry::sim::test
