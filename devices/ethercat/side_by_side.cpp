#include "devices/ethercat/side_by_side.hpp"

#include <algorithm>

namespace gantry::devices {

void SideBySide::add(std::function<void()> work) {
  workers_.push_back({.fiber = std::make_unique<Fiber>(std::move(work))});
}

bool SideBySide::exchange(std::span<Datagram> of_one_frame, int attempts) {
  Worker& w = *inside_;
  w.asked = of_one_frame;
  w.attempts = attempts;
  w.answered = false;
  w.as_sent.clear();
  for (const Datagram& d : of_one_frame) w.as_sent.emplace_back(d.data.begin(), d.data.end());
  w.fiber->wait();
  return w.answered;
}

void SideBySide::pause_until(Time until) {
  Worker& w = *inside_;
  w.until = until;
  w.fiber->wait();
}

/// Everybody who waits for nothing any more.
void SideBySide::go_on() {
  const Time now = link_.clock().now();
  for (Worker& w : workers_) {
    if (w.fiber->done() || !w.asked.empty() || w.until > now) continue;
    inside_ = &w;
    link_.beside(this);
    w.fiber->resume();
    link_.beside(nullptr);
    inside_ = nullptr;
  }
}

/// One frame with the questions of as many as it holds, each one's whole.
void SideBySide::send_some() {
  std::vector<Datagram> batch;
  std::vector<Worker*> on_board;
  for (std::size_t i = 0; i < workers_.size(); ++i) {
    Worker& w = workers_[(next_ + i) % workers_.size()];
    if (w.asked.empty()) continue;
    batch.insert(batch.end(), w.asked.begin(), w.asked.end());
    if (!on_board.empty() && link_.fitting(batch) < batch.size()) {
      batch.resize(batch.size() - w.asked.size());
      break;
    }
    on_board.push_back(&w);
  }
  next_ = (static_cast<std::size_t>(on_board.back() - workers_.data()) + 1) % workers_.size();
  const bool came_back = link_.attempt_now(batch);
  std::size_t at = 0;
  for (Worker* w : on_board) {
    for (std::size_t i = 0; i < w->asked.size(); ++i, ++at) {
      w->asked[i].working_counter = batch[at].working_counter;
      if (!came_back) std::copy(w->as_sent[i].begin(), w->as_sent[i].end(), w->asked[i].data.begin());
    }
    if (!came_back && --w->attempts > 0) continue;
    w->answered = came_back;
    w->asked = {};
    w->until = {};
  }
}

void SideBySide::run() {
  for (;;) {
    go_on();
    bool all_done = true, anybody_asks = false;
    Time first = kNever;
    for (const Worker& w : workers_) {
      if (w.fiber->done()) continue;
      all_done = false;
      if (w.asked.empty())
        first = std::min(first, w.until);
      else
        anybody_asks = true;
    }
    if (all_done) return;
    if (anybody_asks)
      send_some();
    else if (const Time now = link_.clock().now(); first > now)
      link_.pause(first - now);
  }
}

}  // namespace gantry::devices
