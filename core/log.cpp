#include "core/log.hpp"

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "core/clean_text.hpp"
#include "core/status_line.hpp"

namespace gantry {

std::string to_text(const Error& e) {
  return fmt::format("{}{}{} [{}]", clean_text(e.where), e.where.empty() ? "" : ": ", clean_text(e.message),
                     code(e.fault));
}

namespace log {

void open(Level level) {
  auto logger =
      spdlog::stderr_color_mt("gantry", no_color() ? spdlog::color_mode::never : spdlog::color_mode::automatic);
  logger->set_pattern("%^%L%$ %H:%M:%S.%e %v");
  logger->set_level(level == Level::Quiet ? spdlog::level::warn
                                          : (level == Level::Verbose ? spdlog::level::debug : spdlog::level::info));
  spdlog::set_default_logger(std::move(logger));
}

void say(Weight weight, std::string_view line) {
  constexpr spdlog::level::level_enum kLevels[] = {spdlog::level::debug, spdlog::level::info, spdlog::level::warn,
                                                   spdlog::level::err};
  const auto level = kLevels[static_cast<int>(weight)];
  if (!spdlog::default_logger_raw()->should_log(level)) return;
  clear_status();
  const std::string clean = clean_lines(line);
  spdlog::default_logger_raw()->log(level, spdlog::string_view_t(clean.data(), clean.size()));
}

}  // namespace log
}  // namespace gantry
