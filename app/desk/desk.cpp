#include "app/desk/desk.hpp"

#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/desk/do_job.hpp"
#include "app/desk/machine_status.hpp"
#include "app/desk/order_line.hpp"
#include "app/record/summary.hpp"
#include "core/units.hpp"

namespace gantry::desk {
namespace {

using Json = nlohmann::ordered_json;

Json failure(const std::vector<Error>& errors) {
  Json list = Json::array();
  for (const Error& e : errors)
    list.push_back({{"code", std::string_view(code(e.fault))}, {"message", e.message}, {"where", e.where}});
  return {{"ok", false}, {"exit_code", static_cast<int>(info(errors.front().fault).exit_code)}, {"errors", list}};
}

}  // namespace

void Desk::end() {
  stop_ = true;
  if (busy_) owner_.interrupt(Error{Fault::Interrupted, "the owner was asked to end", ""});
}

void Desk::poll() {
  if (interrupted_()) end();
  while (auto in = door_.poll()) {
    const auto order = desk::parse_order(in->line);
    if (!order) {
      door_.reply(in->client, failure({order.error()}).dump());
    } else if (run::takes_time(order->kind)) {
      if (busy_ || waiting_)
        door_.reply(in->client, failure({Error{Fault::Refused, "the machine is busy with another order", ""}}).dump());
      else
        waiting_ = Waiting{in->client, *order};
    } else {
      door_.reply(in->client, answer_now(*order).dump());
    }
  }
}

Result<void> Desk::serve() {
  while (!stop_) {
    if (auto alive = owner_.idle(); !alive) return alive;
    if (!waiting_) continue;
    const Waiting next = *waiting_;
    waiting_.reset();
    busy_ = true;
    door_.reply(next.client, carry_out(next.order).dump());
    busy_ = false;
  }
  return {};
}

Json Desk::answer_now(const run::Order& order) {
  if (order.kind == run::OrderKind::Quit) {
    end();
  } else if (auto done = owner_.order(order); !done) {
    return failure({done.error()});
  }
  return status();
}

Json Desk::status() const {
  Json answer = machine_status(machine_, owner_);
  answer["said"] = in_words(answer);
  return answer;
}

Json Desk::carry_out(const run::Order& order) {
  Result<void> done;
  switch (order.kind) {
    case run::OrderKind::Enable: done = owner_.enable(); break;
    case run::OrderKind::Disable: done = owner_.disable(); break;
    case run::OrderKind::Home: done = owner_.home(); break;
    case run::OrderKind::Jog: return jog(order.jog);
    case run::OrderKind::Run: return run_job(order);
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
  return {{"ok", true},
          {"state", cycle::name(owner_.latest().state)},
          {"said", said},
          {"axes", axes},
          {"duration_s", done->duration_s}};
}

Json Desk::run_job(const run::Order& order) {
  const auto prepared = prepare(machine_, order.recipe);
  if (!prepared) return failure(prepared.error());
  const auto done = do_job(machine_, *prepared, {.out = order.out, .dry_run = false}, {&owner_});
  if (!done) return failure({done.error()});
  Json document = record::to_json(done->result);
  document["ok"] = done->result.exit_code == ExitCode::Done;
  document["folder"] = std::filesystem::absolute(done->folder).string();
  return document;
}

}  // namespace gantry::desk
