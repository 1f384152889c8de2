// How the blocks of a job came to their proofs: ahead, or at the moment when they were wanted.
#pragma once
#include <cstddef>
#include <string>

namespace gantry::job {

/// How the blocks of a job came to their proofs.
struct ProofsAhead {
  std::size_t ahead = 0;          ///< proved before they were wanted, or while what was before them went on
  std::size_t at_the_moment = 0;  ///< as soon as it was known where they begin, and the machine stood there
  std::size_t waited = 0;         ///< of both: the machine has stood longer than a cycle for the proof
  double waited_s = 0;
  bool operator==(const ProofsAhead&) const = default;
};

/// "9 of 12 blocks ahead, 3 at the moment; the machine waited for none".
std::string to_text(const ProofsAhead& proofs);

}  // namespace gantry::job
