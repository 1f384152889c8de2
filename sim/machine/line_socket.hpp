// Lines and blocks of bytes over a stream socket that this object owns. Both ends of the world's socket use it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gantry::sim {

class LineSocket {
 public:
  explicit LineSocket(int fd) : fd_(fd) {}
  ~LineSocket();
  LineSocket(const LineSocket&) = delete;
  LineSocket& operator=(const LineSocket&) = delete;

  [[nodiscard]] int fd() const { return fd_; }
  /// Without its line feed. nullopt: the other side is gone, silent for longer than its time-out, or sends a line of
  /// more than 64 MiB.
  std::optional<std::string> read_line();
  bool read_exactly(std::span<std::uint8_t> to);
  /// False when the other side is gone.
  bool write(std::string_view text) { return write(text.data(), text.size()); }
  bool write(std::span<const std::uint8_t> bytes) { return write(bytes.data(), bytes.size()); }

 private:
  bool write(const void* data, std::size_t size);
  bool fill();
  int fd_;
  std::string buffer_;
  std::size_t taken_ = 0;
};

}  // namespace gantry::sim
