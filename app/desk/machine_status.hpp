// What an owner says of its machine: as values for programs, and the same in lines for people.
//   Json answer = machine_status(machine, owner);   answer["said"] = in_words(answer);
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/run/owner.hpp"
#include "config/machine.hpp"

namespace gantry::desk {

/// "ok", "state", "mode" (automatic, setup), "door" (open, closed; null: no input tells), "held", "cycle", "faults"
/// (all that are active, with text and remedy), the job's progress with "feature" (that is dispensed or headed
/// for), "override" and "axes" (position in mm or rad, enabled, referenced).
nlohmann::ordered_json machine_status(const config::Machine& machine, const run::Owner& owner);

/// "3.5 mm": in two digits, and not less.
std::string at_most_mm(double mm);

/// The same facts: state, job or what else is under way, why it stands, faults with their remedies, a line for each
/// axis (rotary ones in deg). No newline at the end.
std::string in_words(const nlohmann::ordered_json& status);

}  // namespace gantry::desk
