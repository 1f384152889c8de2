#include "sim/world/world_log.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include "core/log.hpp"
#include "core/new_file.hpp"

namespace gantry::sim {

namespace {

constexpr std::uint32_t kMagic = 0x474C5752;  // "RWLG"
constexpr std::size_t kRoom = std::size_t{64} << 20, kLeastRoom = std::size_t{64} << 10;

struct Header {
  std::uint32_t magic = kMagic;
  std::uint32_t kind = 0;
  std::uint32_t size = 0;
  std::uint32_t crc = 0;  ///< of kind, size and payload
};
static_assert(sizeof(Header) == 16);

constexpr std::size_t padded(std::size_t n) { return (n + 7) & ~std::size_t{7}; }

std::uint32_t checksum(const Header& h, std::span<const std::byte> payload) {
  return crc32(payload, crc32(std::as_bytes(std::span(&h.kind, 2))));
}

/// The record at `offset`; an empty span of size 0 with magic 0 where there is none.
bool read_header(const std::byte* memory, std::size_t offset, std::size_t end, Header& h) {
  if (offset + sizeof(Header) > end) return false;
  std::memcpy(&h, memory + offset, sizeof h);
  if (h.magic != kMagic || h.size > end - offset - sizeof(Header)) return false;
  return checksum(h, {memory + offset + sizeof(Header), h.size}) == h.crc;
}

}  // namespace

/// IEEE 802.3, reflected 0xEDB88320.
std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t seed) noexcept {
  static constexpr auto kTable = [] {
    std::array<std::uint32_t, 256> t{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t c = i;
      for (int k = 0; k < 8; ++k) c = (c & 1) ? 0xEDB88320U ^ (c >> 1) : c >> 1;
      t[i] = c;
    }
    return t;
  }();
  std::uint32_t c = ~seed;
  for (const std::byte b : bytes) c = kTable[(c ^ static_cast<std::uint8_t>(b)) & 0xFF] ^ (c >> 8);
  return ~c;
}

Result<std::unique_ptr<WorldLog>> WorldLog::open(const std::string& dir) {
  if (auto made = make_folder(dir); !made) return tl::unexpected(made.error());
  const std::string path = dir + "/world.log";
  const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot open the world's log: {}", std::strerror(errno)), path);
  std::unique_ptr<WorldLog> log(new WorldLog(file, path));
  if (::flock(file, LOCK_EX | LOCK_NB) != 0)
    return fail(Fault::SecondOwner, "another simulated machine uses this world; give it another --sim-state folder",
                path);
  const auto bytes = log->read_all();
  if (!bytes) return tl::unexpected(bytes.error());
  Header h;
  std::size_t used = 0;
  while (read_header(bytes->data(), used, bytes->size(), h)) used += padded(sizeof h + h.size);
  if (auto kept = log->keep_tail(std::span(*bytes), used); !kept) return tl::unexpected(kept.error());
  // Whatever stands behind the last whole record is cut, and read as zeros again.
  if (::ftruncate(file, static_cast<off_t>(used)) != 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot cut the world's log: {}", std::strerror(errno)), path);
  log->used_ = used;
  if (auto mapped = log->map(used + kRoom); !mapped) return tl::unexpected(mapped.error());
  if (auto room = log->allocate(); !room) return tl::unexpected(room.error());
  return log;
}

/// Not by a map: to read a hole of a file in memory takes a page, and a full disk has none.
Result<std::vector<std::byte>> WorldLog::read_all() const {
  std::vector<std::byte> bytes(static_cast<std::size_t>(std::max<off_t>(0, ::lseek(file_, 0, SEEK_END))));
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t got = ::pread(file_, bytes.data() + at, bytes.size() - at, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0)
      return fail(Fault::FileUnreadable, fmt::format("cannot read the world's log: {}", std::strerror(errno)), path_);
    at += static_cast<std::size_t>(got);
  }
  return bytes;
}

/// What cannot be read is not lost in silence. Zeros are the room of a writer that was killed.
Result<void> WorldLog::keep_tail(std::span<const std::byte> bytes, std::size_t used) const {
  std::size_t end = bytes.size();
  while (end > used && bytes[end - 1] == std::byte{0}) --end;
  if (end <= used) return {};
  if (used == 0)
    return fail(Fault::FileUnreadable,
                "is no world's log, or its beginning is damaged; move it away to begin a new world", path_);
  const std::string beside = path_ + ".cut";
  if (auto kept = write_new_file(beside, {reinterpret_cast<const char*>(bytes.data() + used), end - used}); !kept)
    return kept;
  log::warn("{}: the last {} bytes are damaged and not remembered; they are kept in {}", path_, end - used, beside);
  return {};
}

Result<void> WorldLog::map(std::size_t bytes) {
  if (::ftruncate(file_, static_cast<off_t>(bytes)) != 0)
    return fail(Fault::FileUnwritable, fmt::format("cannot enlarge the world's log: {}", std::strerror(errno)), path_);
  void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file_, 0);
  if (memory == MAP_FAILED)
    return fail(Fault::FileUnwritable, fmt::format("cannot map the world's log: {}", std::strerror(errno)), path_);
  if (memory_ != nullptr) ::munmap(memory_, mapped_);
  memory_ = static_cast<std::byte*>(memory);
  mapped_ = bytes;
  return {};
}

WorldLog::~WorldLog() {
  tell_refused();
  if (memory_ != nullptr) ::munmap(memory_, mapped_);
  if (memory_ != nullptr && ::ftruncate(file_, static_cast<off_t>(used_)) != 0) {
    // The room stays behind as zeros, which the next reader takes for the end.
  }
  ::close(file_);
}

std::vector<WorldLog::Record> WorldLog::records() const {
  std::vector<Record> out;
  Header h;
  for (std::size_t at = 0; at < used_ && read_header(memory_, at, used_, h); at += padded(sizeof h + h.size))
    out.push_back({static_cast<Kind>(h.kind), {memory_ + at + sizeof h, h.size}});
  return out;
}

bool WorldLog::append(Kind kind, std::span<const std::byte> payload) noexcept {
  const std::size_t size = padded(sizeof(Header) + payload.size());
  if (size > allocated_ - used_) {
    ++refused_;
    return false;
  }
  Header h{kMagic, static_cast<std::uint32_t>(kind), static_cast<std::uint32_t>(payload.size()), 0};
  h.crc = checksum(h, payload);
  // The payload first: a record whose header stands is whole.
  if (!payload.empty()) std::memcpy(memory_ + used_ + sizeof h, payload.data(), payload.size());
  std::memcpy(memory_ + used_, &h, sizeof h);
  used_ += size;
  return true;
}

void WorldLog::tell_refused() const {
  if (refused_ > 0)
    log::warn("{}: the world's log was full: {} records of the last board are not remembered", path_, refused_);
}

Result<void> WorldLog::make_room() {
  tell_refused();
  refused_ = 0;
  if (mapped_ - used_ < kRoom / 2)
    if (auto mapped = map(used_ + kRoom); !mapped) return mapped;
  return allocate();
}

/// A page of the map that a full disk cannot hold would end the program as it is written: the room is taken beforehand,
/// and of a small disk no more than half of what is free.
Result<void> WorldLog::allocate() {
  struct statvfs disk {};
  std::size_t room = mapped_ - used_;
  if (::fstatvfs(file_, &disk) == 0)
    room = std::min<std::size_t>(room, std::max<std::size_t>(kLeastRoom, disk.f_bavail * disk.f_frsize / 2));
  const int problem = ::posix_fallocate(file_, static_cast<off_t>(used_), static_cast<off_t>(room));
  if (problem != 0)
    return fail(Fault::FileUnwritable,
                fmt::format("no room for the world's log: {}; it needs {} KiB", std::strerror(problem), room >> 10),
                path_);
  allocated_ = used_ + room;
  return {};
}

}  // namespace gantry::sim
