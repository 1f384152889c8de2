#include "app/desk/order_line.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "app/desk/answer.hpp"
#include "core/near_word.hpp"
#include "motion/rt/interpolator.hpp"

namespace gantry::desk {
namespace {

constexpr std::size_t kLongestId = 100;
constexpr const char* kUntouched = "untouched";  // record::Board's word; the socket knows no jobs
constexpr int kDeepest = 64;  // in brackets: nothing that is asked for has more than three, an id of 100 bytes 50

/// What an order carries besides "order" and "id".
struct Key {
  run::OrderKind order;
  const char* name;
  std::string& (*text)(run::Order&);  ///< null: not a text
};
constexpr std::array kKeys{
    Key{run::OrderKind::Run, "recipe", [](run::Order& o) -> std::string& { return o.recipe; }},
    Key{run::OrderKind::Run, "out", [](run::Order& o) -> std::string& { return o.out; }},
    Key{run::OrderKind::Run, "under", [](run::Order& o) -> std::string& { return o.under; }},
    Key{run::OrderKind::Run, "serial", [](run::Order& o) -> std::string& { return o.serial; }},
    Key{run::OrderKind::Run, "force", nullptr},
    Key{run::OrderKind::Run, "certificate", [](run::Order& o) -> std::string& { return o.certificate; }},
    Key{run::OrderKind::Run, "from", nullptr},
    Key{run::OrderKind::Run, "finish", nullptr},
    Key{run::OrderKind::Run, "only", nullptr},
    Key{run::OrderKind::PartRemoved, "serial", [](run::Order& o) -> std::string& { return o.serial; }},
    Key{run::OrderKind::Home, "only", nullptr},
    Key{run::OrderKind::Jog, "by", nullptr},
    Key{run::OrderKind::Jog, "speed", [](run::Order& o) -> std::string& { return o.jog.speed; }},
    Key{run::OrderKind::Override, "value", nullptr},
    Key{run::OrderKind::Hold, "now", nullptr},
    Key{run::OrderKind::Hold, "mine", nullptr},
    Key{run::OrderKind::Abort, "mine", nullptr},
};
constexpr std::array kStops{run::OrderKind::Abort, run::OrderKind::Hold, run::OrderKind::Quit};
static_assert(kStops.size() == kStopKinds);

bool stops(run::OrderKind kind) { return stop_kind(kind).has_value(); }

/// A text that the system would read up to there only: another file, another name than was meant.
bool has_nul(const nlohmann::json& json) {
  if (json.is_string()) return json.get_ref<const std::string&>().find('\0') != std::string::npos;
  if (!json.is_structured()) return false;
  for (const auto& [key, value] : json.items())
    if (key.find('\0') != std::string::npos || has_nul(value)) return true;
  return false;
}

/// Texts go into the order. A key that is not meant here moves nothing: it is refused, but an order that stops is
/// taken.
Result<void> take_texts(const nlohmann::json& json, run::Order& order) {
  for (const auto& [name, value] : json.items()) {
    if (name == "order" || name == "id") continue;
    std::vector<std::string_view> known{"order", "id"};
    const Key* key = nullptr;
    for (const Key& k : kKeys)
      if (k.order == order.kind) {
        known.emplace_back(k.name);
        if (name == k.name) key = &k;
      }
    if (key == nullptr) {
      if (stops(order.kind)) continue;
      return fail(Fault::Refused,
                  fmt::format("'{}' has no key \"{}\"; {}", run::name(order.kind), name, did_you_mean(name, known)));
    }
    if (!stops(order.kind) && has_nul(value))
      return fail(Fault::Refused, fmt::format("\"{}\" of '{}' has a NUL byte in it", name, run::name(order.kind)));
    if (key->text == nullptr) continue;
    if (!value.is_string())
      return fail(Fault::Refused, fmt::format("\"{}\" of '{}' is a text in quotes", name, run::name(order.kind)));
    key->text(order) = value.get<std::string>();
  }
  return {};
}

bool is_list_of_texts(const nlohmann::json& json) {
  return json.is_array() && !json.empty() &&
         std::all_of(json.begin(), json.end(), [](const auto& name) { return name.is_string(); });
}

/// A job that was meant for some features must not do all of them because of a slip.
Result<recipes::Selection> selection_of(const nlohmann::json& json) {
  recipes::Selection out;
  if (const auto from = json.find("from"); from != json.end()) {
    if (!from->is_string() || from->get_ref<const std::string&>().empty())
      return fail(Fault::Refused, R"("from" is the name of a feature, for example "dam")");
    out.from = from->get<std::string>();
  }
  if (const auto only = json.find("only"); only != json.end()) {
    if (!is_list_of_texts(*only))
      return fail(Fault::Refused, R"("only" is a list of names of features, for example ["dam", "dots[0][3]"])");
    out.only = only->get<std::vector<std::string>>();
  }
  if (const auto finish = json.find("finish"); finish != json.end()) {
    if (!finish->is_boolean()) return fail(Fault::Refused, R"("finish" is true or false)");
    out.finish = finish->get<bool>();
  }
  return out;
}

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
  if (auto taken = take_texts(json, order); !taken) return tl::unexpected(taken.error());
  if (const std::string wrong = run::wrong_with_serial(order.serial); !wrong.empty() && !stops(order.kind))
    return fail(Fault::Refused, "\"serial\" " + wrong);
  if (const auto serial = json.find("serial"); serial != json.end() && order.serial.empty() && !stops(order.kind))
    return fail(Fault::Refused, R"("serial" is empty; leave it out where the part has none)");
  if (order.kind == run::OrderKind::Run) {
    if (const auto force = json.find("force"); force != json.end()) {
      if (!force->is_boolean()) return fail(Fault::Refused, R"("force" is true or false)");
      order.force = force->get<bool>();
    }
    auto selected = selection_of(json);
    if (!selected) return tl::unexpected(selected.error());
    order.select = std::move(*selected);
  }
  if (const auto only = json.find("only"); order.kind == run::OrderKind::Home && only != json.end()) {
    if (!is_list_of_texts(*only))
      return fail(Fault::Refused, R"("only" is a list of names of axes, for example ["C", "U"])");
    order.axes = only->get<std::vector<std::string>>();
  }
  if (order.kind == run::OrderKind::Jog) {
    const auto by = json.find("by");
    if (by == json.end() || !by->is_object() || by->empty() ||
        !std::all_of(by->begin(), by->end(), [](const auto& distance) { return distance.is_string(); }))
      return fail(Fault::Refused, R"('jog' needs "by": axes with how far they go, for example {"X": "10 mm"})");
    for (const auto& [axis, distance] : by->items()) order.jog.by[axis] = distance.get<std::string>();
  }
  if (order.kind == run::OrderKind::Run && order.recipe.empty())
    return fail(Fault::Refused, "'run' needs \"recipe\": the path of a recipe");
  if (order.certificate.empty() && json.contains("certificate"))
    return fail(Fault::Refused, "\"certificate\" is the path of a dry run's certificate.json");
  if (const auto now = json.find("now"); order.kind == run::OrderKind::Hold && now != json.end())
    order.now = !now->is_boolean() || now->get<bool>();  // an order that stops is taken whatever else it says
  // What is not said clearly stops everything.
  const bool may_be_mine = order.kind == run::OrderKind::Abort || order.kind == run::OrderKind::Hold;
  if (const auto mine = json.find("mine"); may_be_mine && mine != json.end())
    order.mine = mine->is_boolean() && mine->get<bool>();
  if (order.kind == run::OrderKind::Override) {
    if (!json.contains("value") || !json["value"].is_number())
      return fail(Fault::Refused, "'override' needs \"value\": 0, or 0.01 to 2");
    order.value = json["value"].get<double>();
    if (order.value != 0 && !(order.value >= motion::kLeastOverride && order.value <= motion::kMostOverride))
      return fail(Fault::Refused, "an override is 0, which holds, or 0.01 to 2, which is 1 to 200 %");
  }
  return order;
}

/// A line that is no JSON, because it was cut or is not UTF-8, but says plainly that it stops something: taken as that,
/// whatever the rest was to say. Nothing: it says no such thing.
std::optional<run::Order> stop_in_broken_line(std::string_view line) {
  constexpr std::string_view kBlank = " \t\r", kKey = "\"order\"";
  const auto skip = [&](std::size_t at) { return std::min(line.find_first_not_of(kBlank, at), line.size()); };
  if (skip(0) == line.size() || line[skip(0)] != '{') return std::nullopt;
  for (std::size_t at = line.find(kKey); at != std::string_view::npos; at = line.find(kKey, at + 1)) {
    const std::size_t colon = skip(at + kKey.size());
    if (colon == line.size() || line[colon] != ':') continue;
    const std::string_view value = line.substr(skip(colon + 1));
    for (const run::OrderKind kind : kStops)
      if (value.starts_with(fmt::format("\"{}\"", run::name(kind)))) return run::Order{.kind = kind, .now = true};
  }
  return std::nullopt;
}

}  // namespace

Request read_request(std::string_view line) {
  if (line.size() > kLongestLine) return {fail(Fault::Refused, "an order is one line of at most 64 KiB")};
  bool too_deep = false;  // what is nested without end is not kept: who copies or writes it would run out of stack
  const auto json = nlohmann::json::parse(
      line,
      [&](int depth, nlohmann::json::parse_event_t, const nlohmann::json&) {
        too_deep = too_deep || depth > kDeepest;
        return depth <= kDeepest;
      },
      false);
  if (json.is_discarded())
    if (auto stop = stop_in_broken_line(line)) {
      const run::OrderKind kind = stop->kind;
      return {*std::move(stop), {}, kind};
    }
  Request request{order_of(json)};
  if (json.is_object() && json.contains("order") && json["order"].is_string())
    request.asked = run::order_named(json["order"].get_ref<const std::string&>());
  const bool stop = request.order && stops(request.order->kind);
  if (json.is_object() && json.contains("id")) {
    const auto& id = json["id"];
    const bool is_one =
        !too_deep && id.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).size() <= kLongestId;
    if (is_one)
      request.id = id;
    else if (!stop)
      request.order = fail(Fault::Refused, "an \"id\" has at most 100 bytes");
  } else if (too_deep && !stop) {
    request.order = fail(Fault::Refused, fmt::format("an order is nested in at most {} brackets", kDeepest));
  }
  return request;
}

std::string to_line(const run::Order& order, const nlohmann::ordered_json& id) {
  nlohmann::ordered_json json{{"order", run::name(order.kind)}};
  if (!id.is_null()) json["id"] = id;
  if (!order.recipe.empty()) json["recipe"] = order.recipe;
  if (!order.out.empty()) json["out"] = order.out;
  if (order.force) json["force"] = true;
  if (!order.under.empty()) json["under"] = order.under;
  if (!order.serial.empty()) json["serial"] = order.serial;
  if (!order.certificate.empty()) json["certificate"] = order.certificate;
  if (!order.select.from.empty()) json["from"] = order.select.from;
  if (!order.select.only.empty()) json["only"] = order.select.only;
  if (order.select.finish) json["finish"] = true;
  if (!order.axes.empty()) json["only"] = order.axes;
  if (!order.jog.by.empty()) json["by"] = order.jog.by;
  if (!order.jog.speed.empty()) json["speed"] = order.jog.speed;
  if (order.kind == run::OrderKind::Override) json["value"] = order.value;
  if (order.now) json["now"] = true;
  if (order.mine) json["mine"] = true;
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::optional<unsigned> stop_kind(run::OrderKind kind) {
  const auto found = std::find(kStops.begin(), kStops.end(), kind);
  return found != kStops.end() ? std::optional(static_cast<unsigned>(found - kStops.begin())) : std::nullopt;
}

bool may_stop(std::string_view line) {
  return std::any_of(kStops.begin(), kStops.end(),
                     [&](run::OrderKind kind) { return line.find(run::name(kind)) != std::string_view::npos; });
}

Json answer_to(const Request& request, Json answer) {
  if (request.asked) answer["order"] = run::name(*request.asked);
  if (request.asked == run::OrderKind::Run && !answer.contains("board")) answer["board"] = kUntouched;
  if (!request.id.is_null()) answer["id"] = request.id;
  return answer;
}

}  // namespace gantry::desk
