// An owner's job: what it does with each snapshot and event, and one recipe from its first block to its end.
#include <algorithm>
#include <chrono>

#include "app/record/outcome.hpp"
#include "app/record/summary.hpp"
#include "app/run/owner_parts.hpp"
#include "app/stations/fault_words.hpp"
#include "core/log.hpp"

namespace gantry::run {
namespace {

/// Notes about one station, or its emergency of one code, do not hold back those about another.
int of(const cycle::Event& e) {
  if (e.station == cycle::kNoStation) return -1;
  return e.station.value << 16 | (e.fault == Fault::EmergencyMessage ? e.detail & 0xFFFF : 0);
}

}  // namespace

void Owner::Parts::on_step() {
  if (publisher) publisher->poll(clock->now());
  if (poll) poll();
  if (culprits) look_at_stations();  // may step on itself
}

void Owner::Parts::on_snapshot(const cycle::Snapshot& s) {
  if (shared) shared->push(s);
  if (recording != nullptr) recording->add(s);
}

void Owner::Parts::on_event(const cycle::Event& e) {
  if (e.kind != cycle::EventKind::Fault) {
    if (shared) shared->push(e);
  } else if (culprits && stations::Culprits::wanted(e.fault)) {
    culprits->ask(e);
  } else {
    tell(e, stations::in_words(machine, e));
  }
}

void Owner::Parts::tell(const cycle::Event& e, const Error& error) {
  if (shared) shared->push(e, error.message);
  if (info(e.fault).severity == Severity::Info) return;
  const std::int64_t now_ns = feed->latest().time_ns;
  std::optional<std::string> words = to_text(error);
  if (info(e.fault).reaction == Reaction::Note) words = notes.tell({e.fault, of(e)}, now_ns, std::move(*words));
  if (!words) return;
  log::warn("{}", *words);
  if (recording != nullptr) recording->note(now_ns, *words);
}

void Owner::Parts::look_at_stations() {
  const cycle::Snapshot& now = feed->latest();
  culprits->watch(now);
  while (const auto known = culprits->next()) {
    Error words = stations::in_words(machine, known->event);
    words.where = known->where;
    words.message += known->what;
    tell(known->event, words);
    if (latches(info(words.fault))) named = std::move(words);
  }
  const auto tell_news = [&](const std::vector<stations::StationNews::Item>& items) {
    for (const stations::StationNews::Item& item : items)
      tell({.kind = cycle::EventKind::Fault,
            .fault = item.words.fault,
            .station = item.station,
            .detail = item.detail,
            .cycle = now.cycle},
           item.words);
  };
  tell_news(news->counted(now.time_ns));
  if (!up || on_bus || !news->mail()) return;
  on_bus = true;
  bus->step_by([this] { control->step(); });
  tell_news(news->fetch());
  bus->step_by({});
  on_bus = false;
}

Result<void> Owner::Parts::with_stations(Result<void> result) {
  if (result || !result.error().where.empty()) return result;
  const Fault fault = result.error().fault;
  while (culprits->waiting(fault)) control->step();
  if (named && named->fault == fault) return tl::unexpected(*named);
  return result;
}

record::JobResult Owner::run(const recipes::Recipe& recipe, const recipes::Job& job, const RunOptions& options) {
  Parts& p = *parts_;
  record::JobResult result = record::begin_result(p.machine, recipe, job, options.out, options.dry_run);
  result.bus = p.options.bus;
  const auto wall_start = std::chrono::steady_clock::now();

  p.control->begin();
  p.named.reset();
  Recording recording(p.machine, result, latest().time_ns, options.out, p.shared ? &*p.shared : nullptr);
  Runner runner({p.machine, *p.control, p.world != nullptr ? &p.world->camera() : nullptr}, recipe, job, result);
  p.recording = &recording;
  recording.tell("running");

  Result<void> ended;
  if (p.world != nullptr) {
    const auto held = p.world->holds_board(recipe);
    if (!held)
      ended = tl::unexpected(held.error());
    else if (!*held)
      ended = p.world->load_board(recipe);
    if (ended) ended = p.world->begin_job();
  }
  if (ended) ended = enable();
  p.runner = &runner;
  if (ended) ended = p.with_stations(runner.run());
  if (!ended) record::add_error(result, ended.error());

  recording.tell(record::result_word(result));
  p.runner = nullptr, p.recording = nullptr;
  p.around = runner.surroundings();
  p.control->forget_abort();
  recording.finish(recipe, p.channels->lost.load() == 0);
  result.cycles.virtual_time = p.options.virtual_time;
  if (p.thread)
    result.cycles.real_time_priority = p.thread->rights().priority,
    result.cycles.memory_locked = p.thread->rights().memory;
  if (p.world != nullptr) record::add_world(result, *p.world, options.out);
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
}

Progress Owner::progress() const {
  const Parts& p = *parts_;
  if (p.recording == nullptr) return {};
  return {.features_done = p.recording->features_seen(),
          .features_total = p.recording->features_total(),
          .doing = p.runner != nullptr ? p.runner->doing() : "homing",
          .elapsed_s = p.recording->elapsed_s()};
}

}  // namespace gantry::run
