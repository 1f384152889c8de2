#include "app/run/order.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace gantry::run {
namespace {

struct Row {
  OrderKind kind;
  std::string_view name;
};
constexpr std::array kOrders{
    Row{OrderKind::Status, "status"},     Row{OrderKind::Enable, "enable"}, Row{OrderKind::Disable, "disable"},
    Row{OrderKind::Home, "home"},         Row{OrderKind::Jog, "jog"},       Row{OrderKind::Run, "run"},
    Row{OrderKind::Hold, "hold"},         Row{OrderKind::Resume, "resume"}, Row{OrderKind::Abort, "abort"},
    Row{OrderKind::Override, "override"}, Row{OrderKind::Reset, "reset"},   Row{OrderKind::Quit, "quit"}};
constexpr std::size_t kLongestLine = 64 * 1024;

}  // namespace

std::string_view name(OrderKind kind) {
  for (const Row& row : kOrders)
    if (row.kind == kind) return row.name;
  return "?";
}

Result<Order> parse_order(std::string_view line) {
  if (line.size() > kLongestLine) return fail(Fault::Refused, "an order is one line of at most 64 KiB");
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("order") || !json["order"].is_string())
    return fail(Fault::Refused, R"(an order is one JSON object a line, for example {"order": "status"})");
  const auto& wanted = json["order"].get_ref<const std::string&>();
  Order order;
  bool known = false;
  std::string names;
  for (const Row& row : kOrders) {
    if (row.name == wanted) order.kind = row.kind, known = true;
    names += (names.empty() ? "" : ", ") + std::string(row.name);
  }
  if (!known) return fail(Fault::Refused, fmt::format("there is no order '{}'; there are: {}", wanted, names));
  const auto text = [&](const char* key, std::string& into) {
    if (json.contains(key) && json[key].is_string()) into = json[key].get<std::string>();
  };
  text("recipe", order.recipe);
  text("out", order.out);
  text("speed", order.jog.speed);
  if (order.kind == OrderKind::Jog) {
    const auto by = json.find("by");
    if (by == json.end() || !by->is_object() || by->empty() ||
        !std::all_of(by->begin(), by->end(), [](const auto& way) { return way.is_string(); }))
      return fail(Fault::Refused, R"('jog' needs "by": axes with how far they go, for example {"X": "10 mm"})");
    for (const auto& [axis, way] : by->items()) order.jog.by[axis] = way.get<std::string>();
  }
  if (order.kind == OrderKind::Run && order.recipe.empty())
    return fail(Fault::Refused, "'run' needs \"recipe\": the path of a recipe");
  if (order.kind == OrderKind::Override) {
    if (!json.contains("value") || !json["value"].is_number())
      return fail(Fault::Refused, "'override' needs \"value\": 0.1 to 2");
    order.value = json["value"].get<double>();
    if (!(order.value >= 0.1 && order.value <= 2.0)) return fail(Fault::Refused, "an override lies between 0.1 and 2");
  }
  return order;
}

std::string to_line(const Order& order) {
  nlohmann::ordered_json json{{"order", name(order.kind)}};
  if (!order.recipe.empty()) json["recipe"] = order.recipe;
  if (!order.out.empty()) json["out"] = order.out;
  if (!order.jog.by.empty()) json["by"] = order.jog.by;
  if (!order.jog.speed.empty()) json["speed"] = order.jog.speed;
  if (order.kind == OrderKind::Override) json["value"] = order.value;
  return json.dump();
}

}  // namespace gantry::run
