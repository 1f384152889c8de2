#include "app/run/order.hpp"

#include <array>
#include <fmt/format.h>

#include "core/clean_text.hpp"
#include "core/each_in_order.hpp"

namespace gantry::run {
namespace {

struct Row {
  OrderKind kind;
  std::string_view name;
};
constexpr std::array kOrders{Row{OrderKind::Status, "status"},   Row{OrderKind::Enable, "enable"},
                             Row{OrderKind::Disable, "disable"}, Row{OrderKind::Home, "home"},
                             Row{OrderKind::Jog, "jog"},         Row{OrderKind::Park, "park"},
                             Row{OrderKind::Run, "run"},         Row{OrderKind::PartRemoved, "part_removed"},
                             Row{OrderKind::Hold, "hold"},       Row{OrderKind::Resume, "resume"},
                             Row{OrderKind::Abort, "abort"},     Row{OrderKind::Override, "override"},
                             Row{OrderKind::Reset, "reset"},     Row{OrderKind::Quit, "quit"}};
static_assert(each_in_order(kOrders, &Row::kind, OrderKind::Quit));

}  // namespace

std::string wrong_with_serial(const std::string& serial) {
  constexpr std::size_t kMostBytes = 128;
  if (serial.size() > kMostBytes) return fmt::format("has {} bytes; write at most {}", serial.size(), kMostBytes);
  return clean_text(serial) == serial ? "" : "has a line break or another control character in it; write plain text";
}

std::string_view name(OrderKind kind) { return kOrders[static_cast<std::size_t>(kind)].name; }

std::optional<OrderKind> order_named(std::string_view wanted) {
  for (const Row& row : kOrders)
    if (row.name == wanted) return row.kind;
  return std::nullopt;
}

std::vector<std::string_view> order_names() {
  std::vector<std::string_view> names;
  for (const Row& row : kOrders) names.push_back(row.name);
  return names;
}

}  // namespace gantry::run
