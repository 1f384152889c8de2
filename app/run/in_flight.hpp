// What the run thread has asked of the loop and the loop has not answered yet. Nothing here waits, lets time pass or
// calls anybody: whoever lets time pass polls it, so that an order may be given at any moment, also from within a step.
//   InFlight asked(channels);   const Request r = asked.ask({.kind = CommandKind::Reset});
//   each step: asked.hand_over();   each event: asked.see(event);   if (const auto answer = asked.answer(r)) ...
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <optional>

#include "app/cycle/channels.hpp"

namespace gantry::run {

/// A command whose answer is still to come.
struct Request {
  std::uint32_t id = 0;
};

class InFlight {
 public:
  explicit InFlight(cycle::Channels& channels) : channels_(channels) {}

  /// Sends, behind everything that was sent before. What the loop's ring has no room for waits here.
  void post(cycle::Command command);
  /// The same, and the answer is kept for whoever asks for it.
  Request ask(cycle::Command command);
  /// What waits goes on into the ring, as far as there is room.
  void hand_over();
  /// An event of the loop.
  void see(const cycle::Event& event);
  /// Nothing as long as it has not come; once told, it is forgotten.
  std::optional<cycle::Event> answer(Request request);
  /// Nobody asks for this answer any more.
  void forget(Request request) { answers_.erase(request.id); }
  /// More waits than the loop takes in several cycles: whoever asks people for orders takes no more of them.
  [[nodiscard]] bool crowded() const { return waiting_.size() >= kCrowd; }

  static constexpr std::size_t kCrowd = 64;

 private:
  cycle::Channels& channels_;
  std::uint32_t next_id_ = 1;
  std::deque<cycle::Command> waiting_;
  std::map<std::uint32_t, std::optional<cycle::Event>> answers_;  ///< by id; nothing: not answered yet
};

}  // namespace gantry::run
