// An owner's job: what it does with each snapshot and event, and one recipe from its first block to its end.
#include <algorithm>
#include <bit>
#include <chrono>
#include <fmt/format.h>
#include <utility>

#include "app/job/settle.hpp"
#include "app/record/defects.hpp"
#include "app/record/drawing.hpp"
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

/// A job that looks at marks is refused without a camera before anything moves.
Result<void> camera_for(const recipes::Recipe& recipe, const recipes::Job& job, bool connected) {
  if (connected) return {};
  for (const recipes::Block& block : job.blocks)
    if (const auto* look = std::get_if<recipes::LookAtMark>(&block.what))
      return fail(Fault::CameraTimeout,
                  "the job looks at marks, and no camera is connected: where `gantry sim` is the machine, `--world` "
                  "names its socket; a recipe with `placement: fixture` needs no camera",
                  job::at_line(recipe, recipe.marks[look->mark].location));
  return {};
}

/// A late cycle is nothing to speak of, but for one that was late by several: then the host has stood still.
bool stood_still(const config::Machine& machine, const cycle::Event& e) {
  constexpr int kCycles = 5;
  return e.fault == Fault::LateCycle && microseconds(e.detail) > kCycles * machine.bus.cycle;
}

std::string result_in_words(const record::JobResult& result) {
  std::string words = fmt::format("{}; board: {}", record::result_word(result), record::name(result.board));
  for (const record::Defect& d : result.defects)
    words += d.feature.empty() ? fmt::format("; {}", record::name(d.kind))
                               : fmt::format("; '{}' {}", d.feature, record::name(d.kind));
  return words;
}

/// A board of this recipe lies in the machine, and what becomes of it counts from here on.
Result<void> begin_in(sim::WorldAccess& world, const recipes::Recipe& recipe, bool another_board) {
  const auto held = world.holds_board(recipe);
  if (!held) return tl::unexpected(held.error());
  if (!*held || another_board)
    if (auto loaded = world.load_board(recipe); !loaded) return loaded;
  return world.begin_job();
}

}  // namespace

void Owner::Parts::on_snapshot(const cycle::Snapshot& s) {
  if (shared) shared->push(s);
  active.see(s);
  watch_alarms(s);
  watch_references(s);
  if (on_bus) on_bus->buttons.watch(s.inputs, s.latched != Fault::None);
  if (!job) return;
  job->runner.see(s);
  job->recording.add(s, control().holds_next(), s.state == cycle::State::Homing ? "homing" : job->runner.doing(),
                     job->runner.left_s());
}

/// Some times a second: what the list holds is put into words each time.
void Owner::Parts::watch_alarms(const cycle::Snapshot& s) {
  constexpr std::int64_t kEvery_ns = 50'000'000;
  if (!shared || s.time_ns - alarms_told_ns < kEvery_ns) return;
  alarms_told_ns = s.time_ns;
  shared->alarms(active.list(machine, s));
}

/// Homing gives up what it is to find; whatever else takes a reference is told by its axes.
void Owner::Parts::watch_references(const cycle::Snapshot& s) {
  const std::uint32_t lost = referenced & ~s.referenced;
  referenced = s.referenced;
  if (lost == 0 || s.state == cycle::State::Homing) return;
  std::string names;
  for (const config::Axis& axis : machine.axes)
    if ((lost >> axis.id.value & 1u) != 0) names += (names.empty() ? "" : ", ") + axis.name;
  const std::string words = fmt::format("not referenced any more: {}; `home` finds them", names);
  log::warn("{}", words);
  if (job) job->recording.note(s.time_ns, words);
}

void Owner::Parts::acted(const std::string& what) {
  if (shared) shared->push(monitor::Told::Action, feed->latest().cycle, what);
  if (job) job->recording.action(what);
}

void Owner::Parts::tell_part(const std::string& what) {
  if (shared) shared->push(monitor::Told::Part, feed->latest().cycle, what);
}

void Owner::Parts::on_event(const cycle::Event& e) {
  if (e.kind != cycle::EventKind::Fault) {
    if (shared) shared->push(e);
  } else if (on_bus && stations::Culprits::wanted(e.fault)) {
    on_bus->culprits.ask(e);
  } else {
    tell(e, stations::in_words(machine, e));
  }
}

void Owner::Parts::tell(const cycle::Event& e, const Error& error) {
  const std::int64_t now_ns = feed->latest().time_ns;
  if (latches(info(e.fault))) {
    active.came(error);
    if (job) job->recording.alarm(now_ns, error);
  }
  if (info(e.fault).reaction != Reaction::Note) return tell_now({{e, error}});
  // A stall is held back neither for cycles that were a little late nor for one of half its length.
  const int what =
      stood_still(machine, e) ? -1 - static_cast<int>(std::bit_width(static_cast<unsigned>(e.detail))) : of(e);
  if (const auto told = notes.tell({e.fault, what}, now_ns, {e, error})) tell_now(*told);
}

void Owner::Parts::tell_now(const HeldNotes::Told& told) {
  const cycle::Event& e = told.note.event;
  if (shared) shared->push(e, told.note.words.message, static_cast<std::uint32_t>(told.count));
  std::string words = to_text(told.note.words) + stations::again(told.count, told.age_ns);
  if (job && outlived(info(e.fault)) && control().outlives_stops())
    words += fmt::format("; the job waits: {}", info(e.fault).remedy);
  if (info(e.fault).severity == Severity::Info && !stood_still(machine, e))
    log::debug("{}", words);
  else
    log::warn("{}", words);
  if (job) job->recording.note(feed->latest().time_ns, words);
}

void Owner::Parts::tell_all() {
  for (const auto& told : notes.flush(feed->latest().time_ns)) tell_now(told);
}

void Owner::Parts::serve() {
  name_culprits();
  fetch_mail();
  report_strays();
  for (const auto& told : notes.due(feed->latest().time_ns)) tell_now(told);
  serve_objects();
}

/// What stations have in no PDO goes by their mailboxes.
void Owner::Parts::serve_objects() {
  if (!bus->has_slow_objects()) return;
  bus->step_by([this] { control().step(); });
  const std::vector<std::string> news = bus->serve_objects();
  bus->step_by({});
  for (const std::string& words : news) {
    log::warn("{}", words);
    if (job) job->recording.note(feed->latest().time_ns, words);
  }
}

void Owner::Parts::name_culprits() {
  on_bus->culprits.watch(feed->latest());
  while (const auto known = on_bus->culprits.next()) {
    Error words = stations::in_words(machine, known->event);
    words.where = known->where;
    words.message += known->what;
    tell(known->event, words);
    if (latches(info(words.fault))) on_bus->named = std::move(words);
  }
}

void Owner::Parts::fetch_mail() {
  const cycle::Snapshot& now = feed->latest();
  const auto tell_news = [&](const std::vector<stations::StationNews::Item>& items) {
    for (const stations::StationNews::Item& item : items)
      tell({.kind = cycle::EventKind::Fault,
            .fault = item.words.fault,
            .station = item.station,
            .detail = item.detail,
            .cycle = now.cycle},
           item.words);
  };
  tell_news(on_bus->news.counted(now.time_ns));
  if (!on_bus->news.mail()) return;
  bus->step_by([this] { control().step(); });
  tell_news(on_bus->news.fetch());
  bus->step_by({});
}

/// Frames that were nobody's answer, at most once a second: those of another master with its address, and all others.
void Owner::Parts::report_strays() {
  constexpr std::int64_t kEvery_ns = 1'000'000'000;
  const cycle::Snapshot& now = feed->latest();
  if (now.time_ns - on_bus->counted_at_ns < kEvery_ns) return;
  on_bus->counted_at_ns = now.time_ns;
  const devices::CyclicCounts before = std::exchange(on_bus->counted, bus->counters());
  const devices::CyclicCounts more = on_bus->counted - before;
  const auto other = bus->other_master();
  const std::uint64_t of_master_before = std::exchange(on_bus->of_master, other ? other->frames : 0);
  const std::uint64_t of_master = on_bus->of_master - of_master_before;
  const auto report = [&](Fault fault, std::uint64_t frames, const std::string& words) {
    if (frames == 0) return;
    const cycle::Event event{.kind = cycle::EventKind::Fault,
                             .fault = fault,
                             .detail = static_cast<std::int32_t>(frames),
                             .cycle = now.cycle};
    Error error = stations::in_words(machine, event);
    error.message += "; " + words;
    tell(event, error);
  };
  if (other)
    report(Fault::ForeignFrame, of_master,
           fmt::format("{} in the last second, {}", of_master, stations::sender_words(other->address)));
  const std::uint64_t of_nobody = more.foreign > of_master ? more.foreign - of_master : 0;
  report(Fault::StrayFrames, more.late + more.duplicate + more.malformed + of_nobody,
         fmt::format("in the last second {} late, {} twice, {} changed on the way, {} of somebody else", more.late,
                     more.duplicate, more.malformed, of_nobody));
}

/// Drives that were without supply.
void Owner::Parts::report_restarts() {
  for (const StationId station : on_bus->recovery.take_restarted()) {
    on_bus->compared = false;
    const cycle::Event event{.kind = cycle::EventKind::Fault,
                             .fault = Fault::DriveLostPower,
                             .station = station,
                             .cycle = feed->latest().cycle};
    tell(event, stations::in_words(machine, event));
  }
}

Result<void> Owner::Parts::with_stations(Result<void> result) {
  if (result || !result.error().where.empty()) return result;
  const Fault fault = result.error().fault;
  while (on_bus->culprits.waiting(fault)) control().idle();
  if (on_bus->named && on_bus->named->fault == fault) return tl::unexpected(*on_bus->named);
  return result;
}

AxisVec Owner::Parts::where_a_job_begins() const {
  AxisVec at = feed->latest().target;
  if (all_referenced()) return at;
  for (std::size_t i = 0; i < machine.axes.size(); ++i)
    if (const auto& homing = machine.axes[i].homing) at[i] = homing->position;
  return at;
}

record::JobResult Owner::run(const recipes::Recipe& recipe, const recipes::Job& job, const RunOptions& options) {
  Parts& p = *parts_;
  record::JobResult result;
  const auto begin_result = [&] {
    result = record::begin_result(p.machine, recipe, job, options.out, options.dry_run);
    result.bus = p.options.bus;
  };
  const auto wall_start = std::chrono::steady_clock::now();
  const auto writer = p.options.virtual_time ? record::FileWriter::Thread::Callers : record::FileWriter::Thread::Own;
  monitor::SnapshotWriter* const watched = p.shared ? &*p.shared : nullptr;
  const Turn turn(p, Undertaking::Job, options.begin);
  if (!turn.taken()) {
    begin_result();
    record::add_error(result, turn.refused().error());
    return result;
  }
  p.tell_all();  // what came before is none of this job's
  Result<void> ended = p.aside(begin_result);
  std::optional<job::Forecast> forecast;
  if (options.forecast != nullptr)
    forecast =
        job::from_here(*options.forecast, p.machine, recipe, job, p.where_a_job_begins(), p.control().valve_shut_s());
  p.job = std::make_unique<RunningJob>(
      Recording(p.machine, recipe, result, latest().time_ns, options.out, watched, writer),
      Site{.machine = p.machine,
           .control = p.control(),
           .camera = p.world != nullptr ? &p.world->camera() : nullptr,
           .around = p.around.get(),
           .breath = [&p] { return p.control().breathe(); },
           .opinion = options.opinion,
           .forecast = forecast ? &*forecast : nullptr,
           .foresight = p.options.virtual_time ? Foresight::Thread::Callers : Foresight::Thread::Own,
           .aside = [&p](const auto& work) { return p.aside(work); }},
      recipe, job, result);
  if (const double factor = latest().override_factor; factor > 1) {
    const std::string words =
        fmt::format("the override returns from {:.0f} to 100 %, as at the start of every job", factor * 100);
    log::warn("{}", words);
    p.job->recording.note(latest().time_ns, words);
    p.control().post({.kind = cycle::CommandKind::Override, .value = 1});
  } else if (factor < 1) {
    const std::string words = fmt::format("an override of {:.0f} % is in force", factor * 100);
    log::warn("{}", words);
    p.job->recording.note(latest().time_ns, words);
  }
  for (const std::string& note : p.bus->notes()) p.job->recording.note(latest().time_ns, note);
  p.job->recording.begin(p.job->runner.left_s());
  const std::string part = options.serial.empty() ? result.job : fmt::format("{}, part {}", result.job, options.serial);
  p.tell_part(part + " begins");
  const bool pressed = p.on_bus->buttons.holding();
  if (pressed) log::warn("button hold is pressed: the job waits before its first motion; `resume` or start lets it go");
  if (p.control().holds_next()) p.job->recording.action(std::string(name(OrderKind::Hold)));  // told to all others
  if (pressed) p.control().hold_next(true), p.button_holds = true;
  const devices::CyclicCounts counted_before = p.bus->counters();
  const std::uint64_t repeats_before = p.bus->mailbox_repeats();
  const std::uint64_t lost_before = p.channels->lost.load();

  if (ended && p.in_setup()) ended = fail(Fault::SetupMode, std::string(info(Fault::SetupMode).text));
  if (ended) ended = camera_for(recipe, job, p.world != nullptr);
  bool seen_by_world = false;  // what it tells before that is of the job before
  if (ended && p.world != nullptr) {
    if (auto r = p.aside(
            [&] { ended = begin_in(*p.world, recipe, options.another_board), seen_by_world = ended.has_value(); });
        !r)
      ended = r;
  }
  if (ended) ended = p.torque();
  if (ended && !p.all_referenced()) ended = p.home(p.unreferenced());
  p.control().outlive_stops(options.outlives_stops);  // a stop in homing ends the job
  if (ended) ended = p.with_stations(p.job->runner.run());
  p.control().outlive_stops(false);
  p.raise_to.reset();
  if (!ended && ended.error().fault == Fault::Aborted && p.control().aborting())
    ended = p.control().not_aborted();  // planning that was given up does not know by whom
  if (!ended) {
    // What the job itself has seen while nobody played, such as a clamp that opened, has latched nowhere.
    const std::string code(std::string_view(gantry::code(ended.error().fault)));
    const bool told =
        std::any_of(result.alarms.begin(), result.alarms.end(), [&](const auto& a) { return a.code == code; });
    if (latches(info(ended.error().fault)) && ended.error().fault != Fault::Aborted &&
        ended.error().fault != Fault::Interrupted && !told)
      p.job->recording.alarm(latest().time_ns, ended.error());
    record::add_error(result, ended.error());
    result.disturbed =
        result.disturbed || ended.error().fault == Fault::Aborted || ended.error().fault == Fault::Interrupted;
  }

  if (seen_by_world) {
    if (!ended) p.control().see_valve_shut(p.machine.sim.valve_close_lag_s);
    record::SeenByWorld seen;  // the result itself is written to by steps
    const bool ends = p.simulated_machine != nullptr && !options.goes_on;
    const auto machine = ends ? sim::WorldAccess::Machine::Ends : sim::WorldAccess::Machine::GoesOn;
    static_cast<void>(p.aside([&] { seen = record::ask_world(*p.world, options.out, machine); }));
    record::add_world(result, std::move(seen));
  }
  const std::vector<job::FeatureState> features = p.job->runner.state().features;  // steps go on writing to its own
  const record::Seen seen{features, p.job->runner.off_speed(), options.before, options.slow_beads,
                          record::sets_out_s(p.machine)};
  record::Drawing drawing;
  record::Judgement judgement;
  static_cast<void>(p.aside([&] {
    drawing = record::placed_drawing(result, recipe, p.machine);
    judgement = record::judge_board(result, recipe, seen, seconds(p.machine.bus.cycle));
  }));
  result.drawing = std::move(drawing);
  record::add_judgement(result, std::move(judgement));
  // A part that lacks something, or of which not all is good, is held until a hand asks for it.
  const bool begun = result.board == record::Board::Begun ||
                     (result.board == record::Board::Untouched && !options.before.whole.empty());
  if (result.exit_code == ExitCode::Done && !begun) {
    // What has come since the last motion is the job's end; what comes once the clamp was told to open is behind it.
    auto over = p.control().ended();
    if (over) over = p.release_part();
    if (!over) record::add_error(result, over.error());
  }
  p.tell_all();
  p.job->recording.over(record::result_word(result));
  p.tell_part(fmt::format("{}: {}", part, result_in_words(result)));
  p.around = p.job->runner.surroundings();
  const std::uint64_t lost = p.channels->lost.load() - lost_before;
  if (lost != 0)
    log::report(Error{Fault::EventsLost, fmt::format("{} ({} were lost)", info(Fault::EventsLost).text, lost), ""});
  RecordedFiles files = p.job->recording.finish(lost == 0);
  std::unique_ptr<RunningJob> over = std::move(p.job);
  static_cast<void>(p.aside([&] {
    over.reset();
    files.close(result);
  }));
  if (const double factor = latest().override_factor; factor > p.machine.override_max) {
    log::warn("the override returns from {:.0f} to 100 %: the job's materials allowed it, the machine does not",
              factor * 100);
    p.control().post({.kind = cycle::CommandKind::Override, .value = 1});
  }
  result.cycles.virtual_time = p.options.virtual_time;
  result.cycles.frames_lost_max = p.frames_lost_max;
  result.cycles.frames = p.bus->counters() - counted_before;
  result.cycles.mailbox_repeats = p.bus->mailbox_repeats() - repeats_before;
  if (const auto& thread = p.on_bus->thread)
    result.cycles.real_time_priority = thread->rights().priority, result.cycles.memory_locked = thread->rights().memory;
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  return result;
}

WireCounts Owner::wire() const {
  const devices::StationBus& bus = *parts_->bus;
  const auto other = bus.other_master();
  return {.frames = bus.counters(),
          .mailbox_repeats = bus.mailbox_repeats(),
          .other_master = other ? stations::sender_words(other->address) : ""};
}

Progress Owner::progress() const {
  const Parts& p = *parts_;
  if (!p.job) return {};
  return {.features_done = p.job->recording.features_done(),
          .features_total = p.job->recording.features_total(),
          .doing = latest().state == cycle::State::Homing ? "homing" : p.job->runner.doing(),
          .feature = p.job->runner.feature(),
          .elapsed_s = p.job->recording.elapsed_s(),
          .remaining_s = p.job->recording.remaining_s(),
          .override_next = p.raise_to};
}

}  // namespace gantry::run
