#include "app/cli/client.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/desk/order_line.hpp"
#include "app/desk/order_socket.hpp"
#include "core/log.hpp"

namespace gantry::cli {

bool ask_owner(Context& context, const std::string& state_dir, const run::Order& order) {
  auto client = desk::OrderClient::connect(owner_socket(state_dir));
  if (!client) return false;
  log::info("'{}' goes to the owner that is up", run::name(order.kind));
  if (!client->send(desk::to_line(order))) {
    context.exit_code = show(Error{Fault::Refused, "the owner does not listen", owner_socket(state_dir)}, context.json);
    return true;
  }
  bool aborted = false;
  for (;;) {
    const auto line = client->read_line(milliseconds(200));
    if (terminal_lost()) {  // a job does not depend on its client
      context.exit_code = show(
          Error{Fault::Interrupted, "the terminal is gone; the owner goes on", owner_socket(state_dir)}, context.json);
      return true;
    }
    if (interrupted() && !aborted) {
      aborted = true;
      client->send(desk::to_line({.kind = run::OrderKind::Abort}));
    }
    if (!line && client->gone()) {
      context.exit_code =
          show(Error{Fault::Refused, "the owner has ended before it answered", owner_socket(state_dir)}, context.json);
      return true;
    }
    if (!line) continue;
    const auto answer = nlohmann::ordered_json::parse(*line, nullptr, false);
    if (!answer.is_object()) continue;
    const bool of_abort = aborted && !answer.contains("exit_code");
    if (of_abort) continue;
    if (context.json)
      fmt::print("{}\n", answer.dump(2));
    else if (answer.contains("result"))
      fmt::print("{}  ({}/report.html)\n", answer["result"].get<std::string>(), answer.value("folder", ""));
    else
      fmt::print("{}\n", answer.value("ok", false) ? answer.value("said", answer.value("state", "done")) : "failed");
    if (answer.contains("errors"))
      for (const auto& e : answer["errors"])
        fmt::print(stderr, "{}{}{} [{}]\n", e.value("where", ""), e.value("where", "").empty() ? "" : ": ",
                   e.value("message", ""), e.value("code", ""));
    context.exit_code = aborted                     ? static_cast<int>(ExitCode::Interrupted)
                        : answer.value("ok", false) ? 0
                                                    : answer.value("exit_code", 1);
    return true;
  }
}

}  // namespace gantry::cli
