#include "app/desk/desk.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <memory>
#include <unistd.h>

#include "app/desk/answer.hpp"
#include "app/desk/do_job.hpp"
#include "app/desk/figures.hpp"
#include "app/desk/machine_status.hpp"
#include "app/record/defects.hpp"
#include "app/record/summary.hpp"
#include "app/run/refusal.hpp"
#include "config/yaml.hpp"
#include "core/log.hpp"
#include "core/units.hpp"

namespace gantry::desk {
namespace {

const Error kAbortedBefore{Fault::Aborted, "the operator aborted it before anything moved", ""};
const Error kTakenBack{Fault::Interrupted, "its client took it back before anything moved", ""};
const Error kClientEnds{Fault::Interrupted,
                        "the program that ordered it was interrupted; the machine has come to rest "
                        "and the valve is closed",
                        ""};
const Error kEnding{Fault::Interrupted, "the owner was asked to end", ""};
constexpr const char* kClampShut = "\n  clamp          shut; `gantry part-removed` opens it";
constexpr Time kTaken = milliseconds(10);  // by then the loop has heard of an order, and was heard

/// The loop carries it out, and needs no longer than some cycles for it.
bool goes_to_the_loop(run::OrderKind kind) {
  using run::OrderKind;
  return kind == OrderKind::Hold || kind == OrderKind::Resume || kind == OrderKind::Override ||
         kind == OrderKind::Abort;
}

bool holds(const run::Order& order) {
  return order.kind == run::OrderKind::Hold || (order.kind == run::OrderKind::Override && order.value == 0);
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
  for (const OrderSocket::Incoming& in : door_.turn(clock_.now())) take(in);
  std::erase_if(taken_back_, [this](const auto& entry) { return !door_.knows(entry.first); });
  tell_given({});
  watch_hold();
  watch_start_button();
  watch_hold_button();
  watch_jog();
}

void Desk::take(const OrderSocket::Incoming& in) {
  const std::uint64_t client = in.client;
  tell_given(client);
  Request request = read_request(in.line);
  if (!request.order) return reply(client, request, failure({request.order.error()}));
  if (taken_back(in, request.order->kind)) return reply(client, request, failure({kTakenBack}));
  if (request.order->kind == run::OrderKind::Reset) return reset(client, request);
  if (goes_to_the_loop(request.order->kind)) return give(client, request, in.number);
  if (!run::takes_time(request.order->kind)) return reply(client, request, answer_now(client, *request.order));
  if (in.number < aborted_up_to_) return reply(client, request, failure({kAbortedBefore}));
  if (doing_ || waiting_) {
    run::Standing now = owner_.standing();
    now.undertaking =
        run::undertaking_of((doing_ ? doing_ : waiting_)->request.order->kind);  // also of a job that begins
    return reply(client, request, failure({Error{Fault::Refused, run::refusal(request.order->kind, now), ""}}));
  }
  door_.set_busy(client, true);
  waiting_ = Waiting{client, std::move(request)};
}

void Desk::reply(std::uint64_t client, const Request& request, Json answer) {
  if (request.order) answer["order"] = run::name(request.order->kind);
  if (request.order && request.order->kind == run::OrderKind::Run && !answer.contains("board"))
    answer["board"] = record::name(record::Board::Untouched);
  if (!request.id.is_null()) answer["id"] = request.id;
  door_.reply(client, to_line(answer));
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

void Desk::give(std::uint64_t client, const Request& request, std::uint64_t number) {
  if (request.order->mine) {
    abort_own(client, number);
    return reply(client, request, status());
  }
  if (request.order->kind == run::OrderKind::Abort) abort_what_waits(number);
  std::string said;
  if (const auto kept = hold_what_begins(*request.order)) {
    said = *kept;
  } else {
    if (auto done = owner_.order(*request.order); !done) return reply(client, request, failure({done.error()}));
    const bool says = request.order->kind == run::OrderKind::Hold || request.order->kind == run::OrderKind::Override;
    if (says) said = owner_.order_said();
    const std::optional<double> stop_mm = owner_.stop_mm();  // of before the loop has taken the order
    if (stop_mm && said.starts_with("holds now")) said += fmt::format(", within {:.2g} mm", *stop_mm);
    if (stop_mm && request.order->kind == run::OrderKind::Abort) said = fmt::format("stops within {:.2g} mm", *stop_mm);
  }
  if (!hold_ && holds(*request.order)) {
    const bool by_override = request.order->kind == run::OrderKind::Override;
    hold_ = Hold{.by = by_override ? Hold::By::Override : Hold::By::Order, .client = client};
  }
  given_.push_back({{client, request}, clock_.now() + kTaken, std::move(said)});
  door_.set_busy(client, true);
}

std::optional<std::string> Desk::hold_what_begins(const run::Order& order) {
  using run::OrderKind;
  const bool waits = waiting_ && waiting_->request.order->kind == OrderKind::Run;
  if (!waits && !(preparing_ && !aborted_)) return std::nullopt;
  if (holds(order)) {
    hold_wished_ = true;
    return "the job is being prepared, and waits before its first motion; `resume` lets it go";
  }
  if (order.kind != OrderKind::Resume || !std::exchange(hold_wished_, false)) return std::nullopt;
  return "the job is being prepared, and begins as soon as it is";
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

/// What only asks, or stops something, is taken all the same.
bool Desk::taken_back(const OrderSocket::Incoming& in, run::OrderKind kind) const {
  using run::OrderKind;
  const bool begins =
      run::takes_time(kind) || kind == OrderKind::Resume || kind == OrderKind::Reset || kind == OrderKind::Override;
  const auto found = taken_back_.find(in.client);
  return begins && found != taken_back_.end() && in.number < found->second;
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
  if (options_.recipe.empty())
    log::warn("button start: no recipe belongs to it; `gantry up --recipe FILE` names one");
  else if (doing_ || waiting_)
    log::warn("button start: the machine is busy with '{}'",
              run::name((doing_ ? doing_ : waiting_)->request.order->kind));
  else
    waiting_ = Waiting{kNobody, {run::Order{.kind = run::OrderKind::Run, .recipe = options_.recipe}}};
}

/// Behind the start button: somebody who presses both wants the job to wait.
void Desk::watch_hold_button() {
  if (!owner_.take_hold()) return;
  const auto kept = hold_what_begins({.kind = run::OrderKind::Hold});
  if (!kept) return log::warn("button hold: nothing is under way that could be held");
  if (!hold_) hold_ = Hold{.by = Hold::By::Button};
  log::info("button hold: {}", *kept);
}

void Desk::finish(const Waiting& done, Json answer) {
  hold_.reset();
  if (done.client == kNobody) {
    for (const Error& e : errors_of(answer)) log::report(e);
    if (answer.contains("folder"))
      log::info("button start: {}: {}", answer.value("result", ""), answer.value("folder", ""));
  }
  reply(done.client, done.request, std::move(answer));
  door_.set_busy(done.client, is_answered_later(done.client));
}

void Desk::watch_jog() {
  const std::optional<Waiting>& at_work = doing_ ? doing_ : waiting_;
  if (!at_work || at_work->request.order->kind != run::OrderKind::Jog) return;
  const auto heard = door_.heard(at_work->client);
  const Time silence = jog_silence(machine_.bus.cycle);
  if (heard && clock_.now() - *heard <= silence) return;
  const Error why{Fault::Aborted,
                  heard ? fmt::format("the jog's client was silent for {} ms", silence / milliseconds(1))
                        : std::string("the jog's client has closed its connection"),
                  ""};
  if (doing_) return owner_.interrupt(why);
  finish(*std::exchange(waiting_, std::nullopt), failure({why}));
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
  return told("fault", why + ", which was reset", goes_on);
}

Json Desk::status(std::uint64_t client) const {
  Json answer = machine_status(machine_, owner_);
  answer["busy_with"] = doing_ ? Json(run::name(doing_->request.order->kind)) : Json(nullptr);
  answer["recipe"] = recipe_.empty() ? Json(nullptr) : Json(recipe_);
  if (preparing_) answer["doing"] = "preparing";
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
    if (!waiting_ || stop_) continue;
    doing_ = std::exchange(waiting_, std::nullopt);
    Json answer = carry_out(*doing_->request.order);
    finish(*std::exchange(doing_, std::nullopt), std::move(answer));
  }
  for (const auto& left : {waiting_, resetting_})
    if (left) finish(*left, failure({kEnding}));
  for (const Told& told : std::exchange(given_, {})) tell(told);
  return {};
}

Json Desk::carry_out(const run::Order& order) {
  Result<void> done;
  switch (order.kind) {
    case run::OrderKind::Enable: done = owner_.enable(); break;
    case run::OrderKind::Disable: done = owner_.disable(); break;
    case run::OrderKind::Home: done = owner_.home(order.axes); break;
    case run::OrderKind::Jog: return jog(order.jog);
    case run::OrderKind::Park: done = owner_.park(); break;
    case run::OrderKind::Run: return run_job(order);
    case run::OrderKind::PartRemoved: return part_removed(order);
    default: break;
  }
  return done ? status() : failure({done.error()});
}

/// "said" is the same for people.
Json Desk::jog(const job::JogWords& words) {
  const auto done = owner_.jog(words);
  if (!done) return failure({done.error()});
  Json axes = Json::array();
  std::string said;
  for (const config::Axis& axis : machine_.axes) {
    if ((done->axes >> axis.id.value & 1u) == 0) continue;
    const double start = done->start[axis.id.value], end = done->end[axis.id.value];
    axes.push_back({{"name", axis.name}, {"unit", axis.rotary ? "rad" : "mm"}, {"start", start}, {"end", end}});
    const double shown = axis.rotary ? units::deg(1) : 1;
    said += fmt::format("{} {:.3f} -> {:.3f} {}, ", axis.name, start * shown, end * shown, axis.rotary ? "deg" : "mm");
  }
  said += fmt::format("{:.3f} s", done->duration_s);
  if (!done->slowed.empty()) said += "; " + done->slowed;
  Json answer{{"ok", true},
              {"state", cycle::name(owner_.latest().state)},
              {"said", said},
              {"axes", axes},
              {"duration_s", done->duration_s}};
  if (!done->slowed.empty()) answer["slowed"] = done->slowed;
  return answer;
}

bool Desk::prepare_aside(std::function<void()> work) {
  const auto serve = [this] {
    if (!aborted_ && !stop_) static_cast<void>(owner_.idle());
    return !aborted_ && !stop_;
  };
  return aside_.run(std::move(work), serve) && !aborted_ && !stop_;
}

/// What was begun and not finished is out of the machine, and nothing is to be done on it any more.
Json Desk::part_removed(const run::Order& order) {
  Result<std::optional<std::string>> another;
  if (options_.parts != nullptr) owner_.aside([&] { another = options_.parts->another_inside(order.serial); });
  if (!another) return failure({another.error()});
  if (!*another)
    if (auto open = owner_.part_removed(); !open) return failure({open.error()});
  if (options_.parts == nullptr) return status();
  Result<std::optional<BegunPart>> forgotten;
  owner_.aside([&] { forgotten = options_.parts->forget_removed(order.serial); });
  if (!forgotten) return failure({forgotten.error()});
  Json answer = status();
  std::string said;
  if (*forgotten || !order.serial.empty()) said = removal_in_words(*forgotten, order.serial) + "\n";
  if (*another)
    said += fmt::format("the clamp stays as it is: the part in the machine {}\n",
                        (*another)->empty() ? "was begun without a serial; `gantry part-removed` alone means it"
                                            : "is '" + config::shortened(**another, 100) + "'");
  answer["said"] = said + answer["said"].get<std::string>();
  return answer;
}

Json Desk::run_job(const run::Order& order) {
  recipe_ = order.recipe, preparing_ = true, aborted_.reset();
  struct Work {
    std::atomic<bool> given_up{false};  ///< nobody waits for it any more
    int unreadable = 0;                 ///< as errno has it
    std::optional<Checked<Prepared>> prepared;
  };
  const auto shared = std::make_shared<Work>();  // outlives this call where an abort ends the waiting
  const bool ready = prepare_aside(
      [shared, &machine = machine_, recipe = order.recipe, select = order.select, certificate = order.certificate] {
        shared->unreadable = ::access(recipe.c_str(), R_OK) == 0 ? 0 : errno;
        if (shared->unreadable == 0)
          shared->prepared =
              prepare(machine, recipe, select,
                      {.certificate = certificate, .breath = [&shared = *shared] { return !shared.given_up; }});
      });
  shared->given_up = !ready;
  // As long as it is prepared, an abort meets no undertaking of the owner and is kept here.
  const auto may_start = [this]() -> Result<void> {
    preparing_ = false;
    if (!aborted_ && !stop_) return {};
    return tl::unexpected(stop_ ? kEnding : *aborted_);
  };
  Json answer = [&]() -> Json {
    if (!ready) return failure({stop_ ? kEnding : *aborted_});
    if (shared->unreadable != 0)
      return failure({Error{Fault::FileUnreadable,
                            fmt::format("the owner, which runs as user {}, cannot read this recipe: {}", ::geteuid(),
                                        std::strerror(shared->unreadable)),
                            order.recipe}});
    const Checked<Prepared>& prepared = *shared->prepared;
    if (!prepared) return failure(prepared.error());
    const Bench bench{.owner = &owner_,
                      .may_start = may_start,
                      .on_hold = [this] { return std::exchange(hold_wished_, false); },
                      .parts = options_.parts};
    const record::WantedFolder folder{
        .path = order.out, .under = order.under.empty() ? "out" : order.under, .overwrite = order.force};
    const auto done = do_job(machine_, *prepared, folder, {.serial = order.serial, .outlives_stops = true}, bench);
    if (!done) return failure({done.error()});
    return {{"ok", done->result.exit_code == ExitCode::Done},
            {"result", record::result_word(done->result)},
            {"exit_code", static_cast<int>(done->result.exit_code)},
            {"board", record::name(done->result.board)},
            {"to_finish", done->result.to_finish.empty() ? Json(nullptr) : Json(done->result.to_finish)},
            {"defects", done->result.defects.size()},
            {"errors", errors_to_json(done->result.errors)},
            {"folder", std::filesystem::absolute(done->folder).string()},
            {"said", figures(done->result) + (done->clamp_holds ? kClampShut : "")}};
  }();
  preparing_ = hold_wished_ = false;
  recipe_.clear();
  return answer;
}

}  // namespace gantry::desk
