// gantry pages man | bash-completion: written from the verbs themselves, so that they name what there is. For packages.
#include <algorithm>
#include <fmt/format.h>

#include "app/cli/terminal.hpp"
#include "app/cli/usage.hpp"
#include "app/cli/verbs.hpp"
#include "app/record/program.hpp"

namespace gantry::cli {
namespace {

std::vector<const CLI::App*> verbs_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* verb) { return !verb->get_group().empty(); });
}

std::string replaced(std::string text, std::string_view what, std::string_view with) {
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

/// As text of a manual page (man-pages(7), groff(7)): no character steers.
std::string roff(std::string text) {
  text = replaced(replaced(std::move(text), "\\", "\\e"), "-", "\\-");
  if (!text.empty() && (text.front() == '.' || text.front() == '\'')) text.insert(0, "\\&");
  return replaced(replaced(std::move(text), "\n.", "\n\\&."), "\n'", "\n\\&'");
}

/// "-q, --quiet", "FILE ..."
std::string names_of(const CLI::Option& option) {
  std::string names;
  for (const std::string& name : option.get_snames()) names += (names.empty() ? "-" : ", -") + name;
  for (const std::string& name : option.get_lnames()) names += (names.empty() ? "--" : ", --") + name;
  return names.empty() ? option.get_name(true) : names;
}

void man_options(const CLI::App& app, std::string& page) {
  for (const CLI::Option* option : app.get_options())
    page += fmt::format(".TP\n.B {}\n{}\n", roff(names_of(*option)), roff(option->get_description()));
}

void man_verb(const CLI::App& verb, const std::string& above, std::string& page) {
  const std::string name = above + " " + verb.get_name();
  page += fmt::format(".SS {}\n{}.\n", roff(name), roff(verb.get_description()));
  man_options(verb, page);
  if (!verb.get_footer().empty()) page += fmt::format(".PP\n{}\n", roff(verb.get_footer()));
  for (const CLI::App* below : verbs_of(verb)) man_verb(*below, name, page);
}

std::string man_page(const CLI::App& app) {
  std::string page = fmt::format(
      ".TH GANTRY 1 \"\" \"gantry {}\" \"User Commands\"\n.SH NAME\ngantry \\- controller for gantry and dispensing "
      "machines\n.SH SYNOPSIS\n.B gantry\n[options] verb [arguments]\n.SH OPTIONS\nThey may stand before or behind the "
      "verb.\n",
      roff(record::program_version()));
  man_options(app, page);
  page += ".SH VERBS\n";
  for (const CLI::App* verb : verbs_of(app)) man_verb(*verb, "gantry", page);
  return page + fmt::format(".SH EXIT STATUS\n{}\n", roff(app.get_footer()));
}

/// Long options of a verb, and all that can stand behind it.
void words_of(const CLI::App& app, std::vector<std::string>& words) {
  for (std::string& name : long_options(app)) words.push_back(std::move(name));
  for (const CLI::App* below : verbs_of(app)) {
    words.push_back(below->get_name());
    words_of(*below, words);
  }
}

std::string listed(std::vector<std::string> words) {
  std::sort(words.begin(), words.end());
  words.erase(std::unique(words.begin(), words.end()), words.end());
  return fmt::format("{}", fmt::join(words, " "));
}

std::string bash_completion(const CLI::App& app) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : verbs_of(app)) verbs.push_back(verb->get_name());
  const std::vector<std::string> options = long_options(app);
  std::string rows;
  for (const CLI::App* verb : verbs_of(app)) {
    std::vector<std::string> words = options;
    words_of(*verb, words);
    rows += fmt::format("    {}) known=\"{}\" ;;\n", verb->get_name(), listed(words));
  }
  return fmt::format(
      "# Completion of gantry's verbs and options for bash; files where a word is neither.\n"
      "_gantry() {{\n"
      "  local word verb= known cur=${{COMP_WORDS[COMP_CWORD]}}\n"
      "  for word in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
      "    case \" {0} \" in *\" $word \"*) verb=$word; break ;; esac\n"
      "  done\n"
      "  case $verb in\n"
      "    '') known=\"{0} {1}\" ;;\n"
      "{2}"
      "  esac\n"
      "  mapfile -t COMPREPLY < <(compgen -W \"$known\" -- \"$cur\")\n"
      "}}\n"
      "complete -o default -F _gantry gantry\n",
      listed(verbs), listed(options), rows);
}

}  // namespace

void add_pages(CLI::App& app, Context&) {
  auto* verb = app.add_subcommand("pages", "Manual page and shell completion, written from the verbs")->group("");
  verb->require_subcommand(1);
  verb->add_subcommand("man", "The manual page gantry(1)")->callback([&app] { print_raw(man_page(app)); });
  verb->add_subcommand("bash-completion", "Completion for bash")->callback([&app] { print_raw(bash_completion(app)); });
}

}  // namespace gantry::cli
