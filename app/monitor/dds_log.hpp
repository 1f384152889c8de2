// What Cyclone DDS says (warnings, errors, traces) goes to our log, a bounded number of lines of it: it has one for
// each malformed packet that somebody sends (R93).
#pragma once

namespace gantry::monitor::dds {

/// For the whole process; to be called before DDS is set up.
void log_in_bounds();

}  // namespace gantry::monitor::dds
