// Scripts for the world: what goes wrong, and when. A YAML list; every entry says `do` and, unless it is meant at once,
// `at`:
//   - {at: feature dot 7, do: drive_fault, axis: X, code: 0x7500}
//   - {at: cycle 12000, do: cut_link, station: y1}
//   - {at: mark M2, do: remove_mark, name: M2}
//   - {at: job start, after: 2 s, do: press, input: stop, hold: 100 ms}
// Read like every YAML file of the house: all mistakes at once with file:line:col and the nearest known word.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "config/machine.hpp"
#include "core/error.hpp"
#include "sim/script/world_event.hpp"

namespace gantry::sim {

/// A list of entries, or one entry alone (a line of stdin).
Checked<std::vector<ScriptEntry>> parse_script(std::string_view yaml, std::string_view file,
                                               const config::Machine& machine);
Checked<std::vector<ScriptEntry>> load_script(const std::string& path, const config::Machine& machine);

/// Many mistakes in one message, for callers with room for one.
Error joined(const std::vector<Error>& errors);

}  // namespace gantry::sim
