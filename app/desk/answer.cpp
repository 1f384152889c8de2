#include "app/desk/answer.hpp"

#include <algorithm>

#include "core/clean_text.hpp"

namespace gantry::desk {
namespace {

constexpr std::size_t kLongestText = 2000;  // of one message; a path is at most 4096 bytes and mostly far shorter

Fault fault_of(std::string_view wanted) {
  for (const FaultInfo& row : catalogue())
    if (std::string_view(code(row.fault)) == wanted) return row.fault;
  return Fault::Internal;
}

std::string text(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

}  // namespace

Json errors_to_json(const std::vector<Error>& errors) {
  Json list = Json::array();
  std::size_t bytes = 0;
  for (const Error& e : errors) {
    const FaultInfo& f = info(e.fault);
    Json one{{"code", std::string_view(code(e.fault))},
             {"name", f.name},
             {"message", e.message.substr(0, kLongestText)},
             {"where", e.where.substr(0, kLongestText)},
             {"remedy", f.remedy}};
    bytes += to_line(one).size();
    if (bytes > kLongestAnswer / 2) break;
    list.push_back(std::move(one));
  }
  return list;
}

Json failure(const std::vector<Error>& errors) {
  Json answer{{"ok", false},
              {"exit_code", static_cast<int>(info(errors.front().fault).exit_code)},
              {"errors", errors_to_json(errors)}};
  if (const std::size_t shown = answer["errors"].size(); shown < errors.size())
    answer["errors_left_out"] = errors.size() - shown;
  return answer;
}

std::vector<Error> errors_of(const Json& answer) {
  std::vector<Error> errors;
  const auto list = answer.find("errors");
  if (list == answer.end() || !list->is_array()) return errors;
  for (const Json& e : *list)
    if (e.is_object()) errors.push_back({fault_of(text(e, "code")), text(e, "message"), text(e, "where")});
  return errors;
}

std::string to_line(const Json& answer) {
  return escape_steering(answer.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace gantry::desk
