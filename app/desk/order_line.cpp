#include "app/desk/order_line.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

namespace gantry::desk {
namespace {

constexpr std::size_t kLongestLine = 64 * 1024;
constexpr std::size_t kLongestId = 100;

Result<run::Order> order_of(const nlohmann::json& json) {
  if (!json.is_object() || !json.contains("order") || !json["order"].is_string())
    return fail(Fault::Refused, R"(an order is one JSON object a line, for example {"order": "status"})");
  const auto& wanted = json["order"].get_ref<const std::string&>();
  run::Order order;
  const auto kind = run::order_named(wanted);
  if (!kind)
    return fail(Fault::Refused,
                fmt::format("there is no order '{}'; there are: {}", wanted, fmt::join(run::order_names(), ", ")));
  order.kind = *kind;
  const auto text = [&](const char* key, std::string& into) {
    if (json.contains(key) && json[key].is_string()) into = json[key].get<std::string>();
  };
  text("recipe", order.recipe);
  text("out", order.out);
  text("under", order.under);
  text("speed", order.jog.speed);
  if (order.kind == run::OrderKind::Jog) {
    const auto by = json.find("by");
    if (by == json.end() || !by->is_object() || by->empty() ||
        !std::all_of(by->begin(), by->end(), [](const auto& way) { return way.is_string(); }))
      return fail(Fault::Refused, R"('jog' needs "by": axes with how far they go, for example {"X": "10 mm"})");
    for (const auto& [axis, way] : by->items()) order.jog.by[axis] = way.get<std::string>();
  }
  if (order.kind == run::OrderKind::Run && order.recipe.empty())
    return fail(Fault::Refused, "'run' needs \"recipe\": the path of a recipe");
  if (order.kind == run::OrderKind::Override) {
    if (!json.contains("value") || !json["value"].is_number())
      return fail(Fault::Refused, "'override' needs \"value\": 0.1 to 2");
    order.value = json["value"].get<double>();
    if (!(order.value >= 0.1 && order.value <= 2.0))
      return fail(Fault::Refused, "an override lies between 0.1 and 2, which is 10 to 200 %; `hold` stops the motion");
  }
  return order;
}

}  // namespace

Request read_request(std::string_view line) {
  if (line.size() > kLongestLine) return {fail(Fault::Refused, "an order is one line of at most 64 KiB")};
  const auto json = nlohmann::json::parse(line, nullptr, false);
  Request request{order_of(json)};
  if (json.is_object() && json.contains("id")) {
    const auto& id = json["id"];
    if (id.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).size() <= kLongestId)
      request.id = id;
    else
      request.order = fail(Fault::Refused, "an \"id\" has at most 100 bytes");
  }
  return request;
}

Result<run::Order> parse_order(std::string_view line) { return read_request(line).order; }

std::string to_line(const run::Order& order, const nlohmann::ordered_json& id) {
  nlohmann::ordered_json json{{"order", run::name(order.kind)}};
  if (!id.is_null()) json["id"] = id;
  if (!order.recipe.empty()) json["recipe"] = order.recipe;
  if (!order.out.empty()) json["out"] = order.out;
  if (!order.under.empty()) json["under"] = order.under;
  if (!order.jog.by.empty()) json["by"] = order.jog.by;
  if (!order.jog.speed.empty()) json["speed"] = order.jog.speed;
  if (order.kind == run::OrderKind::Override) json["value"] = order.value;
  return json.dump();
}

bool is_urgent(std::string_view line) {
  constexpr std::size_t kLongestStop = 1024;  // an order that stops needs no more; a longer line waits for its turn
  constexpr std::array kStops{run::OrderKind::Abort, run::OrderKind::Hold, run::OrderKind::Quit};
  if (line.size() > kLongestStop) return false;
  const auto named = [&](run::OrderKind kind) { return line.find(run::name(kind)) != std::string_view::npos; };
  if (std::none_of(kStops.begin(), kStops.end(), named)) return false;
  const auto order = parse_order(line);
  return order && std::find(kStops.begin(), kStops.end(), order->kind) != kStops.end();
}

}  // namespace gantry::desk
