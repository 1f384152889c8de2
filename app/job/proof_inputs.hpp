// What the proof of a job rests on, as five hashes: two runs with equal ones ask the same motions, of the same axes,
// among the same bodies.
//   ProofInputs inputs = proof_inputs(machine, recipe);   inputs.scene   ->   64 hex digits
// A hash is that of a canonical text of what was read, not of a file's bytes: order of keys, units, comments, paths and
// defaults that are written out change nothing. docs/motion/certificate.md has the text's rules.
#pragma once
#include <array>
#include <string>
#include <string_view>

#include "config/machine.hpp"
#include "recipes/recipe.hpp"

namespace gantry::job {

struct ProofInputs {
  std::string scene;        ///< what stands: bodies of the machine, the board with its parts at their nominal
                            ///< placement, and the zones to keep out of
  std::string head;         ///< what moves: its bodies, and the axes that carry them
  std::string recipe;       ///< all that the recipe says
  std::string limits;       ///< of the axes; clearance, safe height, park position, cycle
  std::string calibration;  ///< tips of the tools, scale of the camera, travel of the probe, work frames
};

struct ProofInput {
  const char* name;
  std::string ProofInputs::*hash;
};
inline constexpr std::array kProofInputs{
    ProofInput{"scene", &ProofInputs::scene}, ProofInput{"head", &ProofInputs::head},
    ProofInput{"recipe", &ProofInputs::recipe}, ProofInput{"limits", &ProofInputs::limits},
    ProofInput{"calibration", &ProofInputs::calibration}};

/// Pure; lowercase SHA-256.
ProofInputs proof_inputs(const config::Machine& machine, const recipes::Recipe& recipe);

}  // namespace gantry::job
