// What people may ask of the owner of a machine, from keys, from the command line and over the local socket
// (app/desk/order_line.hpp has the text form).
#pragma once
#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/job/jog.hpp"
#include "core/clock.hpp"
#include "recipes/selection.hpp"

namespace gantry::run {

/// By then the loop has heard of an order that is carried out at once, and was heard: it is answered. What was pressed
/// before that does not undo it. The order is taken in one cycle, and what it led to is read in another one.
constexpr Time heard_within(Time period) noexcept { return std::max<Time>(milliseconds(10), 4 * period); }

enum class OrderKind {
  Status,
  Enable,
  Disable,
  Home,
  Jog,
  Park,
  Run,
  PartRemoved,
  Hold,
  Resume,
  Abort,
  Override,
  Reset,
  Quit
};

struct Order {
  OrderKind kind = OrderKind::Status;
  std::string recipe{};             ///< Run: path
  std::string out{};                ///< Run: folder for the results; empty: a new one in `under`
  bool force = false;               ///< Run: what another job has left in `out` is overwritten
  std::string under{};              ///< Run: empty: out/ where the owner stands
  std::string serial{};             ///< Run, PartRemoved: of the part
  recipes::Selection select{};      ///< Run
  std::string certificate{};        ///< Run: path of the certificate that it demands; empty: none
  std::vector<std::string> axes{};  ///< Home: these alone; empty: every one
  job::JogWords jog{};              ///< Jog
  double value = 1;                 ///< Override: 1 is 100 %; 0.01 .. 2, or 0: hold now
  bool now = false;                 ///< Hold: does not wait for the end of the feature
  bool mine = false;                ///< Abort, Hold: only what the client that says it has ordered
};

/// Whether the order takes machine time; only one such order runs at a time.
constexpr bool takes_time(OrderKind k) {
  return k == OrderKind::Enable || k == OrderKind::Disable || k == OrderKind::Home || k == OrderKind::Jog ||
         k == OrderKind::Park || k == OrderKind::Run || k == OrderKind::PartRemoved;
}

/// Whether axes move by it, sooner or later.
constexpr bool moves_axes(OrderKind k) {
  return k == OrderKind::Home || k == OrderKind::Jog || k == OrderKind::Park || k == OrderKind::Run;
}

/// What is wrong with a part's serial number, which is one line of text of at most 128 bytes with nothing in it that
/// steers a terminal; "" where nothing is.
std::string wrong_with_serial(const std::string& serial);

std::string_view name(OrderKind kind);
std::optional<OrderKind> order_named(std::string_view name);
/// In the order of the kinds.
std::vector<std::string_view> order_names();

}  // namespace gantry::run
