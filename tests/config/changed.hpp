// Machine files with something changed, beside the shipped profiles, and what is said of them.
#pragma once
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <string>
#include <string_view>
#include <unistd.h>

#include "config/machine.hpp"
#include "config/yaml.hpp"

namespace gantry::config {

namespace fs = std::filesystem;

/// The machine file with one place changed, beside the shipped profiles.
class Changed {
 public:
  Changed() : folder_(fs::path(testing::TempDir()) / ("gantry_machine_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "machines");
    for (const char* kind : {"drives", "devices"})
      if (!fs::exists(folder_ / kind))
        fs::create_directory_symlink(fs::absolute(fs::path("config") / kind), folder_ / kind);
    text_ = *read_text_file("config/machines/dispenser.yaml");
  }
  ~Changed() { fs::remove_all(folder_); }
  /// Replaces the first `from`; the mistake is expected at the next `at` from there on, or else at the last before.
  void swap(const std::string& from, const std::string& to, const std::string& at) {
    const auto found = text_.find(from);
    ASSERT_NE(found, std::string::npos) << from;
    text_.replace(found, from.size(), to);
    auto place = text_.find(at, found);
    if (place == std::string::npos) place = text_.rfind(at, found);
    ASSERT_NE(place, std::string::npos) << at;
    line_ = 1 + static_cast<int>(std::count(text_.begin(), text_.begin() + static_cast<long>(place), '\n'));
    column_ = static_cast<int>(place - (text_.rfind('\n', place - 1) + 1)) + 1;
  }
  /// The same in a drive's profile: "std402ec.yaml".
  void swap_in_profile(const std::string& profile, const std::string& from, const std::string& to) {
    const fs::path drives = folder_ / "drives";
    if (fs::is_symlink(drives)) {
      fs::remove(drives);
      fs::copy(fs::absolute(fs::path("config") / "drives"), drives);
    }
    std::string text = *read_text_file((drives / profile).string());
    const auto found = text.find(from);
    ASSERT_NE(found, std::string::npos) << from;
    std::ofstream(drives / profile) << text.replace(found, from.size(), to);
  }
  [[nodiscard]] std::string where() const {
    return (folder_ / "machines" / "m.yaml").string() + ":" + std::to_string(line_) + ":" + std::to_string(column_);
  }
  Checked<Machine> load() {
    std::ofstream(folder_ / "machines" / "m.yaml") << text_;
    return load_machine((folder_ / "machines" / "m.yaml").string());
  }

 private:
  fs::path folder_;
  std::string text_;
  int line_ = 0, column_ = 0;
};

inline bool warns(const Checked<Machine>& m, std::string_view what) {
  const auto all = m ? notes(*m) : std::vector<std::string>{};
  return std::any_of(all.begin(), all.end(), [&](const std::string& n) { return n.find(what) != std::string::npos; });
}

struct Wrong {
  const char *from, *to, *at;
  Fault fault;
  const char* says;
};
inline void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.to; }
/// The shipped file with this change is refused for one mistake, at its location.
inline void expect_one_mistake(const Wrong& w) {
  Changed file;
  file.swap(w.from, w.to, w.at);
  const auto m = file.load();
  ASSERT_FALSE(m);
  EXPECT_EQ(m.error().size(), 1u) << to_text(m.error().back());
  EXPECT_EQ(m.error()[0].fault, w.fault) << to_text(m.error()[0]);
  EXPECT_EQ(m.error()[0].where, file.where()) << to_text(m.error()[0]);
  EXPECT_NE(m.error()[0].message.find(w.says), std::string::npos) << to_text(m.error()[0]);
}

}  // namespace gantry::config
