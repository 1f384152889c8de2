#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include "app/cli/shipped.hpp"
#include "app/cli/terminal.hpp"
#include "app/cli/verbs.hpp"
#include "app/record/program.hpp"

namespace gantry::cli {
namespace {

nlohmann::ordered_json to_json(const Error& e) {
  const FaultInfo& f = info(e.fault);
  return {{"code", std::string_view(code(e.fault))},
          {"name", f.name},
          {"message", e.message},
          {"where", e.where},
          {"remedy", f.remedy}};
}

nlohmann::ordered_json document_of(std::string_view result, const nlohmann::ordered_json& rest, int exit_code,
                                   const std::vector<Error>& errors) {
  nlohmann::ordered_json document{
      {"result", result}, {"exit_code", exit_code}, {"errors", nlohmann::ordered_json::array()}};
  for (const Error& e : errors) document["errors"].push_back(to_json(e));
  document.insert(rest.begin(), rest.end());  // a key that stands in front stays as it is
  return document;
}

/// What would steer a terminal, or turn the direction of writing, is escaped. `indent` -1: in one line.
std::string to_ascii(const nlohmann::ordered_json& document, int indent) {
  return document.dump(indent, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace

void show_document(std::string_view result, const nlohmann::ordered_json& rest, int exit_code,
                   const std::vector<Error>& errors) {
  print_document(document_of(result, rest, exit_code, errors));
}

void print_document(const nlohmann::ordered_json& document) { print_raw(to_ascii(document, 2)); }

int show_line(const Error& error) {
  const int exit_code = static_cast<int>(info(error.fault).exit_code);
  print_raw(to_ascii(document_of("failed", nlohmann::ordered_json::object(), exit_code, {error}), -1));
  return show(error, false);
}

int show(const std::vector<Error>& errors, bool json, std::string_view board) {
  if (errors.empty()) return static_cast<int>(ExitCode::Done);
  const int exit_code = static_cast<int>(info(errors.front().fault).exit_code);
  if (json) {
    nlohmann::ordered_json rest = nlohmann::ordered_json::object();
    if (board == kBoardUnknown)
      rest["board"] = nullptr;
    else if (!board.empty())
      rest["board"] = board;
    show_document("failed", rest, exit_code, errors);
  }
  for (const Error& e : errors) {
    say("{}\n", to_text(e));
    if (!info(e.fault).remedy.empty()) say("    remedy: {}\n", info(e.fault).remedy);
  }
  return exit_code;
}

int show(const Error& error, bool json, std::string_view board) { return show(std::vector<Error>{error}, json, board); }

void show_version(bool json) {
  const std::string version(record::program_version()), commit(record::program_commit());
  if (json)
    show_document("ok", {{"version", version}, {"commit", commit}});
  else
    print_text("gantry {} ({})\n", version, commit);
}

std::optional<config::Machine> load_machine(Context& context) {
  auto machine = machine_in(context.machine_file);
  if (machine) return std::move(*machine);
  context.exit_code = show(machine.error(), context.json, context.board);
  return std::nullopt;
}

}  // namespace gantry::cli
