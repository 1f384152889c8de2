// What takes machine time, one at a time, and how people are told of it.
//   fail(Fault::Refused, fmt::format("the machine is busy with {}", in_quotes(Undertaking::Job)));
#pragma once
#include <string_view>

#include "app/run/order.hpp"

namespace gantry::run {

enum class Undertaking { None, BringUp, Enable, Disable, Home, Jog, Park, Job, Part, Walk };

/// What carries this order out; None for one that is answered at once.
Undertaking undertaking_of(OrderKind order) noexcept;
/// It moves axes, and can be kept waiting on hold before and between its motions.
bool can_wait(Undertaking what) noexcept;

std::string_view name(Undertaking what);
/// "'run'", as its order is called; "a walk".
std::string_view in_quotes(Undertaking what) noexcept;

}  // namespace gantry::run
