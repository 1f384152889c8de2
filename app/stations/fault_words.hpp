// A fault of the loop in words: which axis, which station, the drive's own text, the figure.
#pragma once
#include "app/cycle/channels.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"

namespace gantry::stations {

Error in_words(const config::Machine& machine, const cycle::Event& event);

}  // namespace gantry::stations
