// Made-up snapshots for the tests of the record.
#pragma once
#include <cmath>
#include <filesystem>
#include <string>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"

namespace gantry::record {

/// A sent tick of a block on two drives.
inline cycle::Snapshot tick_of(std::uint32_t block, std::uint32_t tick, std::int32_t c0 = 0, std::int32_t c1 = 0) {
  cycle::Snapshot s;
  s.state = cycle::State::Running;
  s.block = block;
  s.tick = tick;
  s.drives = 2;
  s.axes = 3;
  s.counts[0] = c0;
  s.counts[1] = c1;
  s.inputs_fresh = true;
  s.complete = true;
  s.working_counter = s.expected = 6;
  return s;
}

/// X Y Z, 1 ms.
inline config::Machine three_axes() {
  config::Machine m;
  for (const char* axis : {"X", "Y", "Z"}) {
    config::Axis a;
    a.id = AxisId{static_cast<std::uint8_t>(m.axes.size())};
    a.name = axis;
    m.axes.push_back(a);
  }
  m.x = AxisId{0}, m.y = AxisId{1}, m.z = AxisId{2};
  return m;
}

/// A folder of its own for each test, gone at the end.
struct Folder {
  std::string path = [] {
    std::string name = (std::filesystem::temp_directory_path() / "gantry-record-XXXXXX").string();
    return std::string(mkdtemp(name.data()));
  }();
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

}  // namespace gantry::record
