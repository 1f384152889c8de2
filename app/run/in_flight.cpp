#include "app/run/in_flight.hpp"

namespace gantry::run {

void InFlight::post(cycle::Command command) {
  command.id = next_id_++;
  waiting_.push_back(command);
  hand_over();
}

Request InFlight::ask(cycle::Command command) {
  const Request request{next_id_};
  answers_.emplace(request.id, std::nullopt);
  post(command);
  return request;
}

void InFlight::hand_over() {
  while (!waiting_.empty() && channels_.commands.push(waiting_.front())) waiting_.pop_front();
}

void InFlight::see(const cycle::Event& event) {
  if (event.kind != cycle::EventKind::CommandDone) return;
  if (const auto asked = answers_.find(event.id); asked != answers_.end()) asked->second = event;
}

std::optional<cycle::Event> InFlight::answer(Request request) {
  const auto asked = answers_.find(request.id);
  if (asked == answers_.end() || !asked->second) return std::nullopt;
  const cycle::Event answer = *asked->second;
  answers_.erase(asked);
  return answer;
}

}  // namespace gantry::run
