// gantry commission AXIS: homes the machine, measures how far the axis lags its command, and keeps that with the date.
#pragma once
#include <string>

#include "app/cli/verbs.hpp"

namespace gantry::cli {

struct AxisOptions {
  std::string axis, interface, speed, state;
};

/// Sets context.exit_code.
void commission_axis(Context& context, config::Machine machine, const AxisOptions& options);

}  // namespace gantry::cli
