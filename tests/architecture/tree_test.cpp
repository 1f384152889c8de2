// Checks of the tree as text: lengths, words that have no place here, links of the docs, packages and licences.
#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <regex>
#include <set>

#include "tests/architecture/source_tree.hpp"

namespace gantry::architecture {
namespace {

TEST(Tree, files_read_in_one_sitting) {
  constexpr long kLook = 500, kTooLong = 650;
  for (const SourceFile& file : source_tree()) {
    if (!is_code(file)) continue;
    const long lines = std::count(file.text.begin(), file.text.end(), '\n');
    EXPECT_LE(lines, kTooLong) << file.path << ": find the second thing in it";
    if (lines > kLook)
      std::printf("long: %s has %ld lines; is there a second thing in it?\n", file.path.c_str(), lines);
  }
}

TEST(Tree, headers_are_guarded_and_open_with_what_they_are_for) {
  for (const SourceFile& file : source_tree()) {
    if (!file.path.ends_with(".hpp")) continue;
    EXPECT_NE(file.text.find("#pragma once"), std::string::npos) << file.path;
    EXPECT_TRUE(file.text.starts_with("// ")) << file.path << ": opens with a comment that says what it is for";
  }
}

TEST(Tree, nothing_names_this_machine_or_a_registry) {
  // Put together from parts, so that this file passes its own check.
  const struct {
    std::regex pattern;
    const char* why;
  } forbidden[] = {
      {std::regex(std::string("(^|[^A-Za-z0-9_.)/])/wo") + "rk/"), "a path of one machine"},
      {std::regex(std::string("/ro") + "ot/|/ho" + "me/[a-z]"), "a path of one machine"},
      {std::regex(std::string("\\.\\./sha") + "red"), "outside of the tree"},
      {std::regex(std::string("(deb|security|snapshot|ftp)\\.deb") + "ian\\.org"), "a registry host"},
      {std::regex(std::string("registry\\.npm") + "js|py" + "pi\\.org|crates\\.i" + "o|proxy\\.gol" + "ang"),
       "a registry host"},
      {std::regex(std::string("GTEST_SK") + "IP\\(\\)(?! << \")|DISABLED" + "_[a-z]"),
       "a test that does not test, and no word why"},
      {std::regex(std::string("\\b(TO") + "DO|FIX" + "ME|XX" + "X)\\b"), "unfinished"},
  };
  for (const SourceFile& file : source_tree()) {
    if (file.text.find('\0') != std::string::npos) continue;  // not text
    std::istringstream lines(file.text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      if (line.size() > 2000) continue;  // data
      for (const auto& row : forbidden)
        EXPECT_FALSE(std::regex_search(line, row.pattern)) << file.path << ":" << number << ": " << row.why;
    }
  }
}

/// GitHub's anchor of a heading: lower case, punctuation dropped, blanks to hyphens.
std::string anchor(const std::string& heading) {
  std::string out;
  for (const char c : heading)
    if (std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-')
      out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    else if (c == ' ')
      out += '-';
  return out;
}

TEST(Docs, relative_links_lead_somewhere) {
  const std::filesystem::path root = GANTRY_SOURCE_DIR;
  const std::regex link(R"(\]\(([^)\s]+)\))");
  for (const SourceFile& file : source_tree()) {
    if (!file.path.ends_with(".md")) continue;
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), link), end; it != end; ++it) {
      const std::string target = (*it)[1];
      if (target.find("://") != std::string::npos || target.starts_with("mailto:")) continue;
      const auto hash = target.find('#');
      const std::filesystem::path path =
          hash == 0 ? root / file.path : (root / file.path).parent_path() / target.substr(0, hash);
      ASSERT_TRUE(std::filesystem::exists(path)) << file.path << ": " << target;
      if (hash == std::string::npos) continue;
      std::istringstream lines(read(path));
      bool found = false;
      for (std::string line; std::getline(lines, line);)
        if (line.starts_with('#'))
          found = found || anchor(line.substr(line.find_first_not_of("# "))) == target.substr(hash + 1);
      EXPECT_TRUE(found) << file.path << ": no heading for " << target;
    }
  }
}

TEST(Docs, every_page_can_be_reached_from_the_index) {
  const std::string index = read(std::filesystem::path(GANTRY_SOURCE_DIR) / "docs/index.md");
  for (const SourceFile& file : source_tree())
    if (within(file.path, "docs") && file.path.ends_with(".md") && file.path != "docs/index.md") {
      EXPECT_NE(index.find("(" + file.path.substr(5) + ")"), std::string::npos)
          << file.path << " is not in docs/index.md";
    }
}

TEST(Docs, scripts_that_pages_name_are_there_and_can_be_started) {
  const std::filesystem::path root = GANTRY_SOURCE_DIR;
  const std::regex script(R"((scripts|\.ci)/[a-z][a-z-]*)");
  for (const SourceFile& file : source_tree()) {
    if (!file.path.ends_with(".md")) continue;
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), script), end; it != end; ++it) {
      const std::filesystem::path path = root / it->str();
      if (std::filesystem::exists(root / (it->str() + ".txt"))) continue;  // a list
      ASSERT_TRUE(std::filesystem::exists(path)) << file.path << " names " << it->str();
      EXPECT_NE(std::filesystem::status(path).permissions() & std::filesystem::perms::owner_exec,
                std::filesystem::perms::none)
          << it->str();
    }
  }
}

TEST(Dependencies, every_package_that_setup_installs_has_its_licence_told) {
  const std::filesystem::path root = GANTRY_SOURCE_DIR;
  const std::string told = read(root / "THIRD_PARTY.md");
  std::istringstream lines(read(root / "scripts/packages.txt"));
  int packages = 0;
  for (std::string line; std::getline(lines, line);) {
    std::string package;
    std::istringstream(line.substr(0, line.find('#'))) >> package;
    if (package.empty()) continue;
    ++packages;
    EXPECT_NE(told.find("`" + package + "`"), std::string::npos) << package << " is not in THIRD_PARTY.md";
  }
  EXPECT_GT(packages, 10);
}

TEST(Dependencies, every_library_that_the_build_looks_for_is_installed_by_setup) {
  const std::string packages = read(std::filesystem::path(GANTRY_SOURCE_DIR) / "scripts/packages.txt");
  const std::regex find(R"(find_package\(\s*([A-Za-z0-9_+-]+))");
  for (const SourceFile& file : source_tree()) {
    if (!file.path.ends_with("CMakeLists.txt") && !file.path.ends_with(".cmake")) continue;
    for (std::sregex_iterator it(file.text.begin(), file.text.end(), find), end; it != end; ++it) {
      const std::string name = (*it)[1];
      if (name == "Threads") continue;  // of the C library
      EXPECT_TRUE(std::regex_search(packages, std::regex("#.*\\b" + name + "\\b")))
          << file.path << " looks for " << name;
    }
  }
}

}  // namespace
}  // namespace gantry::architecture
