// How long a virtual station takes for what is not done by its ESC on the fly. The values are assumed, within the
// bounds that ETG.1020 and the ESC data sheet allow; a test that is not about them may set other ones.
//   segment.set_timing({.al_up = milliseconds(5)});
#pragma once
#include "core/clock.hpp"

namespace gantry::sim {

struct StationTiming {
  Time al_up = microseconds(500);       ///< a step up of the AL state machine, or its refusal
  Time al_down = microseconds(100);     ///< a step down
  Time al_up_max = milliseconds(1000);  ///< SAFE_OP to OP: how long it waits for outputs and SYNC0
  Time sii_read = microseconds(100);    ///< one read command of the SII, 8 bytes
  Time sii_write = milliseconds(2);     ///< one word
  Time sii_reload = milliseconds(1);    ///< the configuration area
  Time restart = milliseconds(100);     ///< after a reset by 0040h, until its ports have a link again
};

}  // namespace gantry::sim
