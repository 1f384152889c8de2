// What `gantry doctor` looks at. Each look gives findings, and changes nothing on this computer.
//   add(findings, look_at_real_time(for_a_machine)); ...       doctor.cpp shows them and gives the exit code
#pragma once
#include <string>
#include <vector>

#include "core/error.hpp"

namespace gantry::cli {

struct Finding {
  enum class Level { Ok, Warning, Error };
  std::string name;  ///< what was looked at: "real-time priority"
  Level level = Level::Ok;
  std::string text;  ///< what was found
  std::string fix;   ///< what to do; empty when all is well
  Fault fault = Fault::None;
};
using Findings = std::vector<Finding>;

/// Rights to real-time priority and locked memory, timer, kernel, CPUs. What a simulated machine can do without is an
/// error where `hardware` is to be driven.
Findings look_at_real_time(bool hardware);

/// The interface that a bus is to be on: exists, up, carrier, raw frames, no other owner, no addresses. "": only
/// whether raw frames may be sent.
Findings look_at_interface(const std::string& interface);

/// Who hears this computer's machines over DDS, by the publishers that run.
Findings look_at_dds();

/// Folders that are written: the state's rights, and room on the disk of both.
Findings look_at_folders(const std::string& state, const std::string& out);

}  // namespace gantry::cli
