// What takes time: one order after the other, while those that come meanwhile are answered between two cycles
// (desk.cpp).
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <unistd.h>

#include "app/desk/answer.hpp"
#include "app/desk/desk.hpp"
#include "app/desk/do_job.hpp"
#include "app/desk/figures.hpp"
#include "app/record/defects.hpp"
#include "app/record/job_folder.hpp"
#include "app/record/summary.hpp"
#include "config/yaml.hpp"
#include "core/absolute_path.hpp"
#include "core/background.hpp"
#include "core/units.hpp"

namespace gantry::desk {

constexpr const char* kClampShut = "\n  clamp          shut; `gantry part-removed` opens it";

Desk::Carried Desk::carry_out(const run::Order& order) {
  Result<void> done;
  switch (order.kind) {
    case run::OrderKind::Enable: done = owner_.enable(); break;
    case run::OrderKind::Disable: done = owner_.disable(); break;
    case run::OrderKind::Home: done = owner_.home(order.axes, begin()); break;
    case run::OrderKind::Jog: return {.answer = jog(order.jog)};
    case run::OrderKind::Park: done = owner_.park(begin()); break;
    case run::OrderKind::Run: return {.answer = run_job(order)};
    case run::OrderKind::PartRemoved: return part_removed(order);
    default: break;
  }
  if (!done) return {.answer = failure({done.error()})};
  return {};
}

/// Of a desk that is not busy any more with what it has done.
Json Desk::status_behind(const std::string& said) const {
  Json answer = status();
  answer["said"] = said + answer["said"].get<std::string>();
  return answer;
}

run::Begin Desk::begin() { return std::exchange(hold_wished_, false) ? run::Begin::OnHold : run::Begin::AtOnce; }

/// "said" is the same for people.
Json Desk::jog(const job::JogWords& words) {
  const auto done = owner_.jog(words, begin(), job::JogFor::Client);
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
Desk::Carried Desk::part_removed(const run::Order& order) {
  Result<std::optional<std::string>> another;
  if (options_.parts != nullptr) owner_.aside([&] { another = options_.parts->another_inside(order.serial); });
  if (!another) return {.answer = failure({another.error()})};
  if (!*another)
    if (auto open = owner_.part_removed(); !open) return {.answer = failure({open.error()})};
  if (options_.parts == nullptr) return {};
  if (!*another) options_.parts->take_out();
  Result<std::optional<BegunPart>> forgotten;
  owner_.aside([&] { forgotten = options_.parts->forget_removed(order.serial); });
  if (!forgotten) {
    if (!*another) forgotten.error().message.insert(0, "the clamp has opened; ");
    return {.answer = failure({forgotten.error()})};
  }
  std::string said;
  if (*forgotten || !order.serial.empty())
    said = removal_in_words(*forgotten, order.serial, !options_.parts->outlives_programs()) + "\n";
  if (*another)
    said += fmt::format("the clamp stays as it is: the part in the machine {}\n",
                        (*another)->empty() ? "was begun without a serial; `gantry part-removed` alone means it"
                                            : "is '" + config::shortened(**another, 100) + "'");
  return {.said = said};
}

std::string_view Desk::board_of(const std::string& serial) {
  record::Board board = record::Board::Untouched;
  if (options_.parts != nullptr) board = options_.parts->board(serial);
  return record::name(board);
}

Json Desk::run_job(const run::Order& order) {
  // From here on an abort and a hold are for this job, also while something is done aside and clients are heard.
  recipe_ = order.recipe, preparing_ = true, aborted_.reset(), in_vain_.clear();
  Result<recipes::Selection> selection;
  owner_.aside([&, clamp = clamp_at(machine_, owner_.latest())] {
    selection = filled_in(order.select, options_.parts, order.serial, clamp);
  });
  struct Work {
    std::atomic<bool> given_up{false};  ///< nobody waits for it any more
    int unreadable = 0;                 ///< as errno has it
    std::optional<Checked<Prepared>> prepared;
  };
  const auto shared = std::make_shared<Work>();  // outlives this call where an abort ends the waiting
  const recipes::Selection select = selection ? *selection : recipes::Selection{};
  const record::WantedFolder folder{
      .path = order.out, .under = order.under.empty() ? "out" : order.under, .overwrite = order.force};
  const bool ready =
      selection && prepare_aside([shared, &machine = machine_, recipe = order.recipe, select,
                                  certificate = order.certificate, folder] {
        come_behind_others();  // a job of thousands of features takes seconds of a processor
        shared->unreadable = ::access(recipe.c_str(), R_OK) == 0 ? 0 : errno;
        if (shared->unreadable != 0) return;
        shared->prepared = prepare(
            machine, recipe, select,
            {.folder = folder, .certificate = certificate, .breath = [&shared = *shared] { return !shared.given_up; }});
      });
  shared->given_up = !ready;
  // As long as it is prepared, an abort meets no undertaking of the owner and is kept here.
  const auto may_start = [this]() -> Result<void> {
    preparing_ = false;
    if (!aborted_ && !stop_) return {};
    return tl::unexpected(why_nothing_begins());
  };
  Json answer = [&]() -> Json {
    if (!selection) return failure({selection.error()});
    if (!ready) return failure({why_nothing_begins()});
    if (shared->unreadable != 0)
      return failure({Error{Fault::FileUnreadable,
                            fmt::format("the owner, which runs as user {}, cannot read this recipe: {}", ::geteuid(),
                                        std::strerror(shared->unreadable)),
                            order.recipe}});
    const Checked<Prepared>& prepared = *shared->prepared;
    if (!prepared) return failure(prepared.error());
    const Bench bench{
        .owner = &owner_, .may_start = may_start, .begin = [this] { return begin(); }, .parts = options_.parts};
    const auto done =
        do_job(machine_, *prepared, folder,
               {.serial = order.serial, .same_machine = options_.same_machine, .outlives_stops = true}, bench);
    if (!done) return failure({done.error()});
    if (!done->begun) in_vain_ = done->folder;
    return {{"ok", done->result.exit_code == ExitCode::Done},
            {"result", record::result_word(done->result)},
            {"exit_code", static_cast<int>(done->result.exit_code)},
            {"board", record::name(done->result.board)},
            {"to_finish", done->result.to_finish.empty() ? Json(nullptr) : Json(done->result.to_finish)},
            {"defects", done->result.defects.size()},
            {"errors", errors_to_json(done->result.errors)},
            {"folder", absolute_path(done->folder).value_or(done->folder)},
            {"said", figures(done->result) + (done->clamp_holds ? kClampShut : "")}};
  }();
  preparing_ = false;
  recipe_.clear();
  return answer;
}

}  // namespace gantry::desk
