#include "app/desk/desk.hpp"

#include <algorithm>
#include <fmt/format.h>

#include "app/desk/answer.hpp"
#include "app/desk/machine_status.hpp"
#include "app/job/hold_to_run.hpp"
#include "app/record/job_folder.hpp"
#include "app/run/refusal.hpp"
#include "core/log.hpp"

namespace gantry::desk {
namespace {

const Error kAbortedBefore{Fault::Aborted, "the operator aborted it before anything moved", ""};
const Error kTakenBack{Fault::Interrupted, "its client took it back before anything moved", ""};
const Error kClientEnds{Fault::Interrupted,
                        "the program that ordered it was interrupted; the machine has come to rest "
                        "and the valve is closed",
                        ""};
const Error kNothingOwn{Fault::Refused,
                        "'hold' is refused: nothing that this connection has ordered is under way, and it asks for "
                        "its own alone; nothing has to be done",
                        ""};
const Error kHeldSince{Fault::Refused, "'resume' is refused: a hold came behind it; give it again", ""};
const Error kEnding{Fault::Interrupted, "the owner was asked to end", ""};

/// The loop carries it out, and needs no longer than some cycles for it.
bool goes_to_the_loop(run::OrderKind kind) {
  using run::OrderKind;
  return kind == OrderKind::Hold || kind == OrderKind::Resume || kind == OrderKind::Override ||
         kind == OrderKind::Abort;
}

bool holds(const run::Order& order) {
  return order.kind == run::OrderKind::Hold || (order.kind == run::OrderKind::Override && order.value == 0);
}

std::string waits_in_words(run::OrderKind what) {
  return fmt::format("'{}' waits before its first motion; `resume` lets it go", run::name(what));
}

/// What nobody waits for, or has taken back, is not to come about any more.
bool begins(const run::Order& order) {
  using run::OrderKind;
  return run::takes_time(order.kind) || order.kind == OrderKind::Resume || order.kind == OrderKind::Reset ||
         (order.kind == OrderKind::Override && !holds(order));
}

}  // namespace

// ---- between two cycles ----

void Desk::end() {
  stop_ = true;
  if (doing_ || bringing_up_) owner_.interrupt(kEnding);
}

void Desk::poll() {
  if (options_.interrupted()) end();
  watch_reset();
  watch_start_button();  // pressed before what is read now: an abort and a hold that come count for its job
  const Time now = clock_.now();
  gap_ = turned_ ? now - *turned_ : Time::max();
  turned_ = now;
  turn_ = door_.turn(now);
  for (taken_ = 0; taken_ < turn_.size();) take(turn_[taken_++]);
  std::erase_if(taken_back_, [this](const auto& entry) { return !door_.knows(entry.first); });
  std::erase_if(held_back_, [this](const auto& e) { return e.first != kNobody && !door_.knows(e.first); });
  tell_given({});
  watch_hold();
  watch_hold_button();
  watch_jog();
}

void Desk::take(const OrderSocket::Incoming& in) {
  const std::uint64_t client = in.client;
  tell_given(client);
  const Request& request = in.request;
  if (!request.order) return reply(client, request, failure({request.order.error()}));
  const run::OrderKind kind = request.order->kind;
  if (begins(*request.order)) {
    if (taken_back(in)) return reply(client, request, failure({kTakenBack}));
    if (door_.hung_up(client)) {  // it may have been killed so that this does not come about
      if (std::exchange(told_hung_up_, client) != client)
        log::warn(
            "'{}', and what else waited behind it, is not carried out: its client has hung up before it was taken",
            run::name(kind));
      return;
    }
  }
  if (kind == run::OrderKind::Reset) return reset(client, request);
  if (goes_to_the_loop(kind)) return give(in);
  if (!run::takes_time(kind)) return reply(client, request, answer_now(client, *request.order));
  if (in.number < aborted_up_to_) return reply(client, request, failure({kAbortedBefore}));
  if (at_work() != nullptr) {
    run::Standing now = owner_.standing();
    now.undertaking = run::undertaking_of(at_work()->request.order->kind);  // also of a job that begins
    return reply(client, request, failure({Error{Fault::Refused, run::refusal(kind, now), ""}}));
  }
  door_.set_busy(client, true);
  waiting_ = Waiting{client, request};
  if (kind == run::OrderKind::Jog && gap_ > job::hold_to_run::silence(machine_.bus.cycle))
    waiting_->unsure_since = turned_;
  const HeldBack* back = run::moves_axes(kind) ? held_back(in) : nullptr;
  if (back != nullptr) hold_wished_ = true, hold_ = back->hold;
}

const Desk::Waiting* Desk::at_work() const { return doing_ ? &*doing_ : waiting_ ? &*waiting_ : nullptr; }

void Desk::reply(std::uint64_t client, const Request& request, Json answer) {
  // Of an order that is none nobody knows the serial.
  if (request.asked == run::OrderKind::Run && !answer.contains("board"))
    answer["board"] = board_of(request.order ? request.order->serial : "");
  door_.reply(client, to_line(answer_to(request, std::move(answer))));
}

Json Desk::answer_now(std::uint64_t client, const run::Order& order) {
  if (order.kind == run::OrderKind::Quit) {
    Json answer = status();
    answer["said"] = "ending: what moves is stopped in order, then torque off and bus down";
    end();
    return answer;
  }
  if (auto done = owner_.order(order); !done) return failure({done.error()});
  return status(client);
}

void Desk::give(const OrderSocket::Incoming& in) {
  const run::Order& order = *in.request.order;
  if (order.kind == run::OrderKind::Abort && order.mine) {
    abort_own(in.client, in.number);
    return reply(in.client, in.request, status());
  }
  if (order.kind == run::OrderKind::Abort) abort_what_waits(in.number);
  if (order.kind == run::OrderKind::Resume) return resume(in);
  if (holds(order)) return hold(in);
  auto said = obey(order);
  if (!said) return reply(in.client, in.request, failure({said.error()}));
  answer_soon(in, *std::move(said));
}

Result<std::string> Desk::obey(const run::Order& order) {
  // Nothing moves yet, and nothing is to be ended: an abort is not meant for the owner itself.
  if (order.kind == run::OrderKind::Abort && owner_.undertaking() == run::Undertaking::BringUp)
    return "nothing is under way; the bus comes up";
  if (auto done = owner_.order(order); !done) return tl::unexpected(done.error());
  const std::optional<double> stop_mm = owner_.stop_mm();  // of before the loop has taken the order
  if (order.kind == run::OrderKind::Abort) return stop_mm ? "stops within " + at_most_mm(*stop_mm) : "";
  if (order.kind == run::OrderKind::Resume) return "";
  std::string said = owner_.order_said();
  const std::size_t now = said.find("holds now");
  if (stop_mm && now != std::string::npos)
    said.insert(std::min(said.find(';'), said.size()), ", within " + at_most_mm(*stop_mm));
  if (order.kind == run::OrderKind::Override && now != std::string::npos) said += "; `resume` goes on";
  return said;
}

void Desk::answer_soon(const OrderSocket::Incoming& in, std::string said) {
  given_.push_back({{in.client, in.request}, clock_.now() + run::heard_within(machine_.bus.cycle), std::move(said)});
  door_.set_busy(in.client, true);
}

void Desk::hold(const OrderSocket::Incoming& in) {
  const run::Order& order = *in.request.order;
  const auto refuse = [&](const Error& why) { reply(in.client, in.request, failure({why})); };
  auto said = hold_what_begins(in);
  const bool meant = !order.mine || (at_work() != nullptr && at_work()->client == in.client);
  const auto before = motion_before(in);
  Error why = kNothingOwn;
  if (!said && meant) {
    if (auto obeyed = obey(order))
      said = *std::move(obeyed);
    else
      why = obeyed.error();
  }
  const bool goes_on = at_work() != nullptr && run::moves_axes(at_work()->request.order->kind);  // it cannot be held
  if (!said && before && !(meant && goes_on)) said = waits_in_words(*before);
  const bool by_override = order.kind == run::OrderKind::Override;
  const Hold asked{.by = by_override ? Hold::By::Override : Hold::By::Order, .client = in.client};
  if (said || before) hold_back(order.mine ? in.client : kNobody, {in.number, asked});
  if (!said) return refuse(why);
  if (!hold_) hold_ = asked;
  answer_soon(in, *std::move(said));
}

/// One that has waited for its turn may be older than the last one.
void Desk::hold_back(std::uint64_t whose, HeldBack back) {
  HeldBack& last = held_back_[whose];
  if (back.number >= last.number) last = std::move(back);
}

std::optional<std::string> Desk::hold_what_begins(const OrderSocket::Incoming& in) {
  const Waiting* next = waiting_ ? &*waiting_ : preparing_ && !aborted_ ? &*doing_ : nullptr;
  if (next == nullptr || !run::moves_axes(next->request.order->kind)) return std::nullopt;
  if (in.request.order->mine && next->client != in.client) return std::nullopt;
  hold_wished_ = true;
  owner_.stop_was_taken();
  if (next->request.order->kind == run::OrderKind::Run)
    return "the job is being prepared, and waits before its first motion; `resume` lets it go";
  return waits_in_words(next->request.order->kind);
}

std::optional<run::OrderKind> Desk::motion_in_line(const IsSuch& is_such) const {
  const auto moves = [&](const OrderSocket::Incoming& line) {
    return line.request.order && run::moves_axes(line.request.order->kind) && is_such(line);
  };
  const auto left = std::find_if(turn_.begin() + static_cast<std::ptrdiff_t>(taken_), turn_.end(), moves);
  const OrderSocket::Incoming* line = left != turn_.end() ? &*left : door_.waiting(moves);
  return line != nullptr ? std::optional(line->request.order->kind) : std::nullopt;
}

std::optional<run::OrderKind> Desk::motion_before(const OrderSocket::Incoming& hold) const {
  return motion_in_line([&](const OrderSocket::Incoming& line) {
    return line.number < hold.number && (!hold.request.order->mine || line.client == hold.client);
  });
}

const Desk::HeldBack* Desk::held_back(const OrderSocket::Incoming& in) const {
  for (const std::uint64_t whose : {kNobody, in.client})
    if (const auto found = held_back_.find(whose); found != held_back_.end() && in.number < found->second.number)
      return &found->second;
  return nullptr;
}

/// One that came before a hold does not undo it.
void Desk::resume(const OrderSocket::Incoming& in) {
  const auto refuse = [&](const Error& why) { reply(in.client, in.request, failure({why})); };
  const bool overtaken =
      std::any_of(held_back_.begin(), held_back_.end(), [&](const auto& e) { return in.number < e.second.number; });
  if (overtaken) return refuse(kHeldSince);
  std::string said;
  if (auto released = let_go()) {
    said = *std::move(released);
  } else if (auto obeyed = obey(*in.request.order); !obeyed) {
    const auto let_go =
        motion_in_line([this](const OrderSocket::Incoming& line) { return held_back(line) != nullptr; });
    if (!let_go) return refuse(obeyed.error());
    said = fmt::format("'{}' begins when it is taken", run::name(*let_go));
  }
  held_back_.clear();
  answer_soon(in, std::move(said));
}

std::optional<std::string> Desk::let_go() {
  if (!std::exchange(hold_wished_, false)) return std::nullopt;
  held_back_.clear();
  return preparing_ ? "the job is being prepared, and begins as soon as it is" : "what waited begins";
}

void Desk::tell_given(std::optional<std::uint64_t> client) {
  std::vector<std::uint64_t> answered;
  std::erase_if(given_, [&](const Told& told) {
    const bool in_order = told.to.request.id.is_null();  // by ids a client tells answers apart in any order
    if (client ? told.to.client != *client || !in_order : clock_.now() < told.due) return false;
    tell(told);
    answered.push_back(told.to.client);
    return true;
  });
  for (const std::uint64_t each : answered) door_.set_busy(each, is_answered_later(each));
}

void Desk::tell(const Told& told) {
  Json answer = status(told.to.client);
  if (!told.said.empty()) answer["said"] = told.said;
  reply(told.to.client, told.to.request, std::move(answer));
}

bool Desk::is_answered_later(std::uint64_t client) const {
  const auto of = [client](const std::optional<Waiting>& order) { return order && order->client == client; };
  return of(waiting_) || of(doing_) || of(resetting_) ||
         std::any_of(given_.begin(), given_.end(), [&](const Told& told) { return told.to.client == client; });
}

void Desk::abort_what_waits(std::uint64_t number) {
  aborted_up_to_ = std::max(aborted_up_to_, number);
  if (waiting_) finish(*std::exchange(waiting_, std::nullopt), failure({kAbortedBefore}));
  if (preparing_ && !aborted_) aborted_ = kAbortedBefore;
  hold_wished_ = false;
}

void Desk::abort_own(std::uint64_t client, std::uint64_t number) {
  taken_back_[client] = number;
  if (waiting_ && waiting_->client == client) finish(*std::exchange(waiting_, std::nullopt), failure({kTakenBack}));
  if (!doing_ || doing_->client != client) return;
  if (preparing_ && !aborted_) aborted_ = kTakenBack;
  hold_wished_ = false;
  owner_.abort(kClientEnds);
}

bool Desk::taken_back(const OrderSocket::Incoming& in) const {
  const auto found = taken_back_.find(in.client);
  return found != taken_back_.end() && in.number < found->second;
}

/// A reset that is taken needs some cycles to find out whether the causes are gone; its client hears what it came to.
void Desk::reset(std::uint64_t client, const Request& request) {
  if (auto taken = owner_.order(*request.order); !taken) return reply(client, request, failure({taken.error()}));
  resetting_ = Waiting{client, request};
  door_.set_busy(client, true);
}

void Desk::watch_reset() {
  const auto answer = owner_.reset_answer();
  if (!answer) return;
  if (const auto to = std::exchange(resetting_, std::nullopt)) {
    reply(to->client, to->request, *answer ? status() : failure({answer->error()}));
    door_.set_busy(to->client, is_answered_later(to->client));
  } else if (!*answer) {  // of the machine's own button
    log::report(answer->error());
  }
}

void Desk::watch_start_button() {
  if (!owner_.take_start() || stop_) return;
  if (const auto released = let_go())
    log::info("button start: {}", *released);
  else if (options_.recipe.empty())
    log::warn("button start: no recipe belongs to it; `gantry up --recipe FILE` names one");
  else if (at_work() != nullptr)
    log::warn("button start: the machine is busy with '{}'", run::name(at_work()->request.order->kind));
  else
    waiting_ = Waiting{kNobody, {run::Order{.kind = run::OrderKind::Run, .recipe = options_.recipe}}};
}

/// Behind the start button: somebody who presses both wants the job to wait.
void Desk::watch_hold_button() {
  if (!owner_.take_hold()) return;
  const OrderSocket::Incoming pressed{kNobody, {run::Order{.kind = run::OrderKind::Hold}}, door_.number()};
  auto kept = hold_what_begins(pressed);
  if (const auto before = motion_before(pressed); !kept && before) kept = waits_in_words(*before);
  if (!kept) return log::warn("button hold: nothing is under way that could be held");
  const Hold asked{.by = Hold::By::Button};
  if (!hold_) hold_ = asked;
  hold_back(kNobody, {pressed.number, asked});
  log::info("button hold: {}", *kept);
}

void Desk::finish(const Waiting& done, Json answer) {
  hold_.reset();
  hold_wished_ = false;
  if (done.client == kNobody) {
    for (const Error& e : errors_of(answer)) log::report(e);
    if (answer.contains("folder"))
      log::info("button start: {}: {}", answer.value("result", ""), answer.value("folder", ""));
    keep_newest_in_vain(answer);
  }
  reply(done.client, done.request, std::move(answer));
  door_.set_busy(done.client, is_answered_later(done.client));
}

/// A button that is pressed again and again over the same mistake leaves the folder of its newest press alone.
void Desk::keep_newest_in_vain(const Json& answer) {
  if (!answer.contains("folder")) return;
  std::optional<InVain> now;
  if (!in_vain_.empty()) now = InVain{in_vain_, answer["errors"].dump()};
  if (now && pressed_in_vain_ && now->errors == pressed_in_vain_->errors)
    owner_.aside([&folder = pressed_in_vain_->folder] { record::take_away(folder); });
  pressed_in_vain_ = std::move(now);
}

void Desk::watch_jog() {
  const Waiting* jog = at_work();
  if (jog == nullptr || jog->request.order->kind != run::OrderKind::Jog) return;
  const auto heard = door_.heard(jog->client);
  const Time silence = job::hold_to_run::silence(machine_.bus.cycle);
  if (heard && clock_.now() - *heard <= silence) return;
  const Error why{Fault::Aborted,
                  heard ? fmt::format("the jog's client was silent for {} ms", silence / milliseconds(1))
                        : std::string("the jog's client has closed its connection"),
                  ""};
  if (doing_) return owner_.interrupt(why);
  finish(*std::exchange(waiting_, std::nullopt), failure({why}));
}

bool Desk::may_begin() const {
  if (!waiting_) return false;
  const auto heard = door_.heard(waiting_->client);
  return !waiting_->unsure_since || (heard && *heard > *waiting_->unsure_since);
}

/// A hold that was asked for may take effect later; one that is over is forgotten.
void Desk::watch_hold() {
  const bool stands = owner_.held() || hold_wished_;
  if (auto stop = owner_.stopped())
    hold_ = Hold{.by = Hold::By::Fault, .stop = std::move(stop)};
  else if (stands && !hold_)
    hold_ = Hold{.by = owner_.held_by_button() ? Hold::By::Button : Hold::By::Terminal};
  if (stood_ && !stands) hold_.reset();
  stood_ = stands;
}

Json Desk::hold_in_words(std::uint64_t client) const {
  if (!hold_ || !(owner_.held() || hold_wished_)) return nullptr;
  const std::string goes_on = "`gantry resume` goes on, `gantry abort` ends it";
  const auto told = [&](const char* by, std::string words, std::string next) -> Json {
    const bool yours = client != kNobody && hold_->client == client;
    return {{"by", by}, {"yours", yours}, {"words", std::move(words)}, {"next", std::move(next)}};
  };
  switch (hold_->by) {
    case Hold::By::Order: return told("order", "held by the order `hold`", goes_on);
    case Hold::By::Override: return told("override", "held by an override of 0 %", goes_on);
    case Hold::By::Button: return told("button", "held by the machine's hold button", "the start button or " + goes_on);
    case Hold::By::Terminal: return told("terminal", "held by Ctrl-Z in the terminal of `gantry up`", goes_on);
    case Hold::By::Fault: break;
  }
  const Error& stop = *hold_->stop;
  const std::string why = fmt::format("stopped: {}", to_text(stop));
  if (owner_.stopped()) return told("fault", why, fmt::format("{}; `gantry abort` ends it", info(stop.fault).remedy));
  if (owner_.latest().latched != Fault::None)  // another one, which the job does not outlive
    return told("fault", why, "`gantry status` names what else is wrong, and the job ends by it");
  return told("fault", why + ", which was reset", goes_on);
}

std::string_view Desk::state_word() const {
  const cycle::State state = owner_.state();
  const bool idle = state == cycle::State::Ready || state == cycle::State::Disabled;
  if (owner_.standing().aborting && (idle || state == cycle::State::Held)) return cycle::name(cycle::State::Stopping);
  if (!idle || at_work() == nullptr) return cycle::name(state);
  if (preparing_ || !doing_) return "preparing";
  switch (doing_->request.order->kind) {
    case run::OrderKind::Enable: return cycle::name(cycle::State::Enabling);
    case run::OrderKind::Disable: return cycle::name(cycle::State::Disabling);
    case run::OrderKind::Home: return cycle::name(cycle::State::Homing);
    default: return cycle::name(cycle::State::Running);
  }
}

Json Desk::status(std::uint64_t client) const {
  Json answer = machine_status(machine_, owner_);
  answer["state"] = state_word();
  answer["busy_with"] = at_work() != nullptr ? Json(run::name(at_work()->request.order->kind)) : Json(nullptr);
  answer["recipe"] = recipe_.empty() ? Json(nullptr) : Json(recipe_);
  if (preparing_)
    answer["doing"] = "preparing";
  else if (!recipe_.empty() && answer["doing"] == "" && answer["features_total"] == 0)  // not yet, or no longer
    answer["doing"] = "busy with its files";
  if (hold_wished_) answer["held"] = true;
  answer["held_by"] = hold_in_words(client);
  const std::optional<double> left = owner_.progress().remaining_s;
  answer["remaining_s"] = left ? Json(*left) : Json(nullptr);
  answer["owner"] = options_.identity;
  answer["said"] = in_words(answer);
  return answer;
}

// ---- one order after the other ----

Result<void> Desk::bring_up() {
  bringing_up_ = true;
  auto up = owner_.bring_up();
  bringing_up_ = false;
  if (!up && stop_) return tl::unexpected(kEnding);
  return up;
}

Result<void> Desk::serve() {
  while (!stop_) {
    if (auto alive = owner_.idle(); !alive) return alive;
    if (!may_begin() || stop_) continue;
    doing_ = std::exchange(waiting_, std::nullopt);
    Carried carried = carry_out(*doing_->request.order);
    const Waiting done = *std::exchange(doing_, std::nullopt);
    finish(done, carried.answer.is_null() ? status_behind(carried.said) : std::move(carried.answer));
  }
  for (const auto& left : {waiting_, resetting_})
    if (left) finish(*left, failure({kEnding}));
  for (const Told& told : std::exchange(given_, {})) tell(told);
  return {};
}

Error Desk::why_nothing_begins() const { return stop_ ? kEnding : *aborted_; }

}  // namespace gantry::desk
