// What the program tells people while it lives, kept for a test.
//   Said said;   ...   EXPECT_TRUE(said.has("station 3 'z'"));   said.lines()
#pragma once
#include <algorithm>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

namespace gantry::test {

class Said {
 public:
  Said() : before_(spdlog::default_logger()) {
    auto logger =
        std::make_shared<spdlog::logger>("said", std::make_shared<spdlog::sinks::ostream_sink_mt>(words_, true));
    logger->set_pattern("%v");
    logger->set_level(spdlog::level::info);
    spdlog::set_default_logger(std::move(logger));
  }
  ~Said() { spdlog::set_default_logger(before_); }
  Said(const Said&) = delete;
  Said& operator=(const Said&) = delete;

  [[nodiscard]] std::string all() const { return words_.str(); }
  [[nodiscard]] std::vector<std::string> lines() const {
    std::vector<std::string> lines;
    std::istringstream in(words_.str());
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }
  /// Lines in which all of these stand.
  [[nodiscard]] int count(std::initializer_list<std::string_view> parts) const {
    int n = 0;
    for (const std::string& line : lines())
      n += std::all_of(parts.begin(), parts.end(),
                       [&](std::string_view part) { return line.find(part) != std::string::npos; });
    return n;
  }
  [[nodiscard]] bool has(std::string_view part) const { return count({part}) > 0; }

 private:
  std::ostringstream words_;
  std::shared_ptr<spdlog::logger> before_;
};

}  // namespace gantry::test
