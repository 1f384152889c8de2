// A fault of the loop in words: which axis, which station, the drive's own text, the figure.
#pragma once
#include <optional>
#include <string>

#include "app/cycle/channels.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "devices/frame_port.hpp"

namespace gantry::stations {

Error in_words(const config::Machine& machine, const cycle::Event& event);
/// "from 02:1B:21:0A:0B:0C": another master, by the source address of its frames as it came in.
std::string sender_words(const devices::MacAddress& sender);

}  // namespace gantry::stations
