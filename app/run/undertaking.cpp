#include "app/run/undertaking.hpp"

#include <array>

#include "core/each_in_order.hpp"

namespace gantry::run {
namespace {

struct UndertakingRow {
  Undertaking what;
  std::string_view name, in_quotes;  ///< the latter as its order is called, where it is one
  bool can_wait;
};
constexpr std::array kUndertakings{
    UndertakingRow{Undertaking::None, "nothing", "nothing", false},
    UndertakingRow{Undertaking::BringUp, "bringing the bus up", "bringing the bus up", false},
    UndertakingRow{Undertaking::Enable, "enabling", "'enable'", false},
    UndertakingRow{Undertaking::Disable, "disabling", "'disable'", false},
    UndertakingRow{Undertaking::Home, "homing", "'home'", true},
    UndertakingRow{Undertaking::Jog, "a jog", "'jog'", true},
    UndertakingRow{Undertaking::Park, "parking", "'park'", true},
    UndertakingRow{Undertaking::Job, "a job", "'run'", true},
    UndertakingRow{Undertaking::Part, "opening the clamp", "'part-removed'", false},
    UndertakingRow{Undertaking::Walk, "a walk", "a walk", false},
};
static_assert(each_in_order(kUndertakings, &UndertakingRow::what, Undertaking::Walk));

const UndertakingRow& row(Undertaking what) noexcept { return kUndertakings[static_cast<std::size_t>(what)]; }

}  // namespace

Undertaking undertaking_of(OrderKind order) noexcept {
  switch (order) {
    case OrderKind::Enable: return Undertaking::Enable;
    case OrderKind::Disable: return Undertaking::Disable;
    case OrderKind::Home: return Undertaking::Home;
    case OrderKind::Jog: return Undertaking::Jog;
    case OrderKind::Park: return Undertaking::Park;
    case OrderKind::Run: return Undertaking::Job;
    case OrderKind::PartRemoved: return Undertaking::Part;
    default: return Undertaking::None;
  }
}

bool can_wait(Undertaking what) noexcept { return row(what).can_wait; }

std::string_view name(Undertaking what) { return row(what).name; }

std::string_view in_quotes(Undertaking what) noexcept { return row(what).in_quotes; }

}  // namespace gantry::run
