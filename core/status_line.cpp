#include "core/status_line.hpp"

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <fmt/format.h>
#include <string>
#include <string_view>
#include <sys/ioctl.h>
#include <unistd.h>

namespace gantry {
namespace {

std::atomic<bool> shown{false};

/// In one piece, and never for long: a reader that is slow costs the line.
void write_out(std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t n = write(STDERR_FILENO, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(n));
  }
}

}  // namespace

bool writes_over(int fd) noexcept {
  const char* const kind = std::getenv("TERM");
  return isatty(fd) != 0 && (kind == nullptr || std::string_view(kind) != "dumb");
}

int columns_of(int fd) noexcept {
  constexpr int kUsual = 80;
  winsize size{};
  return ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string cut_to(std::string_view line, int columns) {
  std::string out;
  bool coloured = false;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == '\x1b') {  // up to its letter: no column
      const std::size_t end = std::min(line.find('m', i), line.size() - 1) + 1;
      out += line.substr(i, end - i);
      coloured = true, i = end;
      continue;
    }
    if (columns-- == 0) break;
    std::size_t end = i + 1;  // with the bytes that continue a character of UTF-8
    while (end < line.size() && (static_cast<unsigned char>(line[end]) & 0xC0u) == 0x80) ++end;
    out += line.substr(i, end - i);
    i = end;
  }
  return coloured ? out + "\x1b[0m" : out;
}

void show_status(std::string_view line) noexcept try {
  shown.store(true);
  write_out(fmt::format("\r\x1b[K\x1b[?7l{}\x1b[?7h", cut_to(line, columns_of(STDERR_FILENO))));
} catch (...) {  // no memory for a line that nobody needs
}

void clear_status() noexcept {
  if (shown.exchange(false)) write_out("\r\x1b[K");
}

bool no_color() noexcept {
  const char* wish = std::getenv("NO_COLOR");
  return wish != nullptr && *wish != '\0';
}

}  // namespace gantry
