// Ethernet frames into a pcapng file (IETF draft-ietf-opsawg-pcapng: section header, one interface in ns, enhanced
// packet blocks), as Wireshark reads it.
//   auto file = PcapngWriter::create("bus.pcapng");   (*file)->add(time, frame);
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/error.hpp"
#include "core/new_file.hpp"

namespace gantry::cli {

class PcapngWriter {
 public:
  /// Fault::FileUnwritable.
  static Result<std::unique_ptr<PcapngWriter>> create(const std::string& path);
  /// `time_ns`: since 1970.
  void add(std::uint64_t time_ns, std::span<const std::byte> frame);
  /// Whether the disk took all of it. Fault::FileUnwritable.
  Result<void> close();
  [[nodiscard]] std::uint64_t frames() const { return frames_; }

 private:
  explicit PcapngWriter(NewFile file) : file_(std::move(file)) {}
  void block(std::uint32_t type, std::span<const std::byte> body);

  NewFile file_;
  std::uint64_t frames_ = 0;
};

}  // namespace gantry::cli
