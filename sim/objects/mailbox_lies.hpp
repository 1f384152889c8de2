// What the mailbox of a virtual station does otherwise than ETG.1000 has it: for tests of who believes it.
//   server.set_lies({.twice = Twice::SameCounter});
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "config/drive.hpp"

namespace gantry::sim {

struct MailboxLies {
  enum class Twice : std::uint8_t { No, SameCounter, NewCounter };
  Twice twice = Twice::No;                           ///< each answer comes twice
  std::optional<std::uint8_t> counter{};             ///< of every answer
  bool emergency_first = false;                      ///< before each answer
  bool never_expedited = false;                      ///< what has four bytes at most comes as a normal transfer
  bool in_segments = false;                          ///< the same, and without a byte of it in the first answer
  bool no_size = false;                              ///< expedited, and not how many of the four bytes count
  bool wrong_toggle = false;                         ///< of segments
  std::optional<config::ObjectAddress> silent_at{};  ///< what is asked of it has no answer
  struct Abort {
    config::ObjectAddress address{};
    std::uint32_t code = 0;
    bool reads = true, writes = true;
  };
  std::optional<Abort> aborts{};
  struct Shown {
    config::ObjectAddress address{};
    std::vector<std::byte> bytes{};
  };
  std::optional<Shown> shows{};  ///< whatever it holds
};

}  // namespace gantry::sim
