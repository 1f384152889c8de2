// gantry explain CODE: what a fault means, what the machine does, how it is cleared; a drive's own codes too.
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/explain_drive.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "core/near_word.hpp"

namespace gantry::cli {
namespace {

/// What is found by whoever prepares or runs a job (files, plans, answers of the world) is an error of that job.
constexpr bool of_a_job(const FaultInfo& f) {
  return static_cast<int>(f.fault) >= 400 && f.severity >= Severity::Error;
}

constexpr std::string_view reaction_text(const FaultInfo& f) {
  switch (f.reaction) {
    case Reaction::Note: return of_a_job(f) ? "what it was found in is refused, or ends" : "noted; motion goes on";
    case Reaction::PathStop: return "stop on the path; drives stay enabled; valve closed";
    case Reaction::AxisStop: return "every axis brakes by itself; drives stay enabled; valve closed";
    case Reaction::QuickStop: return "quick stop, then torque off; valve closed";
    case Reaction::Off: return "everything off at once; valve closed";
  }
  return "";
}

constexpr std::string_view clear_text(Clear c) {
  switch (c) {
    case Clear::None: return "nothing is latched";
    case Clear::Reset: return "reset";
    case Clear::Resume: return "reset; a job goes on with resume";
    case Clear::Reenable: return "reset, then enable the drives";
    case Clear::Rehome: return "reset, enable, and reference the axis again";
    case Clear::Restart: return "restart of the program";
  }
  return "";
}

nlohmann::ordered_json to_json(const FaultInfo& f) {
  return {{"code", std::string_view(code(f.fault))},
          {"name", f.name},
          {"text", f.text},
          {"reaction", reaction_text(f)},
          {"clear", clear_text(f.clear)},
          {"fault_exit_code", static_cast<int>(f.exit_code)},
          {"remedy", f.remedy},
          {"threat", f.threat}};
}

std::string unknown_fault(const std::string& wanted) {
  std::vector<std::string_view> known;
  for (const FaultInfo& row : catalogue())
    if (row.fault != Fault::None) known.push_back(row.name);
  const std::string meant = did_you_mean(wanted, known, "");
  return fmt::format(
      "there is no fault '{}'; {}{}`gantry explain` lists them all, `gantry explain DRIVE` a drive's codes", wanted,
      meant, meant.empty() ? "" : " ");
}

/// "G204", "204" or "FollowingError".
const FaultInfo* look_up(std::string_view wanted) {
  if (!wanted.empty() && (wanted.front() == 'G' || wanted.front() == 'g') && wanted.size() > 1 &&
      std::isdigit(static_cast<unsigned char>(wanted[1])))
    wanted.remove_prefix(1);
  unsigned number = 0;
  const bool numeric =
      std::from_chars(wanted.data(), wanted.data() + wanted.size(), number).ptr == wanted.data() + wanted.size();
  for (const FaultInfo& row : catalogue())
    if ((numeric && static_cast<unsigned>(row.fault) == number) || row.name == wanted) return &row;
  return nullptr;
}

}  // namespace

void add_explain(CLI::App& app, Context& context) {
  auto* verb = app.add_subcommand("explain", "What a fault code means and what to do");
  auto* wanted =
      verb->add_option("CODE",
                       "G204, 204 or a name; a drive's code: std402ec:8611, amd530b:213F.4; std402ec: all of a "
                       "drive; without it: the whole catalogue");
  verb->callback([&context, wanted] {
    if (wanted->count() == 0 && context.json) {
      auto all = nlohmann::ordered_json::array();
      for (const FaultInfo& f : catalogue())
        if (f.fault != Fault::None) all.push_back(to_json(f));
      show_document("ok", {{"faults", all}});
      return;
    }
    if (wanted->count() == 0) {
      for (const FaultInfo& f : catalogue())
        if (f.fault != Fault::None) print_text("{}  {:<22} {}\n", std::string_view(code(f.fault)), f.name, f.text);
      return;
    }
    const auto text = wanted->as<std::string>();
    if (names_drive(text, context.machine_file)) {
      context.exit_code = explain_drive(text, context.machine_file, context.json);
      return;
    }
    const FaultInfo* f = look_up(text);
    if (f == nullptr) {
      context.exit_code = show(Error{Fault::Usage, unknown_fault(text), ""}, context.json);
      return;
    }
    if (context.json) {
      show_document("ok", to_json(*f));
      return;
    }
    print_text("{} {}\n  what:     {}\n  machine:  {}\n  cleared:  {}{}\n  remedy:   {}\n  exit:     {}\n",
               std::string_view(code(f->fault)), f->name, f->text, reaction_text(*f),
               f->clear == Clear::None ? "" : "by ", clear_text(f->clear), f->remedy, static_cast<int>(f->exit_code));
  });
}

}  // namespace gantry::cli
