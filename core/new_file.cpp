#include "core/new_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace gantry {
namespace {

constexpr std::size_t kBuffer = 64 * 1024;

tl::unexpected<Error> unwritable(std::string_view what, int why, const std::string& path) {
  return fail(Fault::FileUnwritable, fmt::format("{}: {}", what, std::strerror(why)), path);
}

/// Files and links are replaced; a device, a pipe or a folder of this name is somebody's on purpose.
Result<void> replaceable(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 || S_ISREG(found.st_mode) || S_ISLNK(found.st_mode)) return {};
  return fail(Fault::FileUnwritable, "what has this name is no file, and is left as it is; choose another name", path);
}

/// errno of the write that failed; 0: none did.
int write_all(int fd, std::string_view left) {
  while (!left.empty()) {
    const ssize_t n = ::write(fd, left.data(), left.size());
    if (n >= 0)
      left.remove_prefix(static_cast<std::size_t>(n));
    else if (errno != EINTR)
      return errno;
  }
  return 0;
}

Result<void> put_in_place(const std::string& beside, const std::string& path) {
  if (::rename(beside.c_str(), path.c_str()) == 0) return {};
  return unwritable("the file cannot be put in place", errno, path);
}

constexpr const char* kNotToItsEnd = "the file could not be written to its end";
constexpr const char* kBeside = ".part";

}  // namespace

Result<NewFile> NewFile::create(const std::string& path) {
  if (const auto slash = path.rfind('/'); slash != std::string::npos && slash > 0)
    if (auto ours = no_foreign_link(path.substr(0, slash)); !ours) return tl::unexpected(ours.error());
  if (auto may = replaceable(path); !may) return tl::unexpected(may.error());
  constexpr int kAttempts = 3;  // who puts something there again and again is told of
  int why = EEXIST;
  for (int i = 0; i < kAttempts && why == EEXIST; ++i) {
    if (::unlink(path.c_str()) != 0 && errno != ENOENT) return unwritable("the file cannot be replaced", errno, path);
    const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (fd >= 0) return NewFile(path, fd);
    why = errno;
  }
  return unwritable("the file cannot be created; check the folder", why, path);
}

NewFile::~NewFile() {
  if (fd_ >= 0) ::close(fd_);
}

NewFile::NewFile(NewFile&& other) noexcept
    : path_(std::move(other.path_)),
      buffer_(std::move(other.buffer_)),
      fd_(std::exchange(other.fd_, -1)),
      failed_(other.failed_) {}

void NewFile::write(std::string_view bytes) {
  buffer_.append(bytes);
  if (buffer_.size() >= kBuffer) flush();
}

void NewFile::flush() {
  if (failed_ == 0) failed_ = write_all(fd_, buffer_);
  buffer_.clear();
}

void NewFile::sync() {
  flush();
  if (failed_ == 0 && ::fsync(fd_) != 0) failed_ = errno;
}

void NewFile::discard() {
  ::unlink(path_.c_str());
  if (fd_ >= 0 && ::ftruncate(fd_, 0) != 0 && failed_ == 0) failed_ = errno;
}

Result<void> NewFile::close() {
  flush();
  struct stat ours {
  }, named{};
  const bool gone = ::fstat(fd_, &ours) == 0 &&
                    (::stat(path_.c_str(), &named) != 0 || named.st_ino != ours.st_ino || named.st_dev != ours.st_dev);
  const bool closed = ::close(std::exchange(fd_, -1)) == 0;
  if (failed_ == 0 && !closed) failed_ = errno;
  if (failed_ != 0) return unwritable(kNotToItsEnd, failed_, path_);
  if (gone) return unwritable("somebody has removed or replaced the file while it was written", ENOENT, path_);
  return {};
}

namespace {

enum class Until { Written, OnDisk };

Result<void> write_file(const std::string& path, std::string_view bytes, Until until) {
  if (auto may = replaceable(path); !may) return may;
  const std::string beside = path + kBeside;
  auto file = NewFile::create(beside);
  if (!file) return tl::unexpected(file.error());
  file->write(bytes);
  if (until == Until::OnDisk) file->sync();
  auto done = file->close();
  if (done) done = put_in_place(beside, path);
  if (!done) ::unlink(beside.c_str());
  return done;
}

/// The names in a folder are on the disk.
Result<void> sync_folder(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool good = fd >= 0 && ::fsync(fd) == 0;
  const int why = errno;
  if (fd >= 0) ::close(fd);
  if (!good) return unwritable("the folder could not be written to the disk", why, path);
  return {};
}

}  // namespace

Result<void> write_new_file(const std::string& path, std::string_view bytes) {
  return write_file(path, bytes, Until::Written);
}

Result<void> name_new_file(int nameless, const std::string& path, std::string_view bytes) {
  if (auto may = replaceable(path); !may) return may;
  int why = write_all(nameless, bytes);
  if (why == 0 && ::ftruncate(nameless, static_cast<off_t>(bytes.size())) != 0) why = errno;
  if (why != 0) return unwritable(kNotToItsEnd, why, path);
  const std::string beside = path + kBeside, self = fmt::format("/proc/self/fd/{}", nameless);
  if (auto may = replaceable(beside); !may) return may;
  ::unlink(beside.c_str());
  if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, beside.c_str(), AT_SYMLINK_FOLLOW) != 0)
    return unwritable("the file cannot be given its name", errno, path);
  auto done = put_in_place(beside, path);
  if (!done) ::unlink(beside.c_str());
  return done;
}

Result<void> write_durable_file(const std::string& path, std::string_view bytes) {
  if (auto done = write_file(path, bytes, Until::OnDisk); !done) return done;
  const auto slash = path.rfind('/');
  return sync_folder(slash == std::string::npos ? "." : path.substr(0, std::max<std::size_t>(slash, 1)));
}

Result<void> no_foreign_link(const std::string& path) {
  for (auto slash = path.find('/', 1);; slash = path.find('/', slash + 1)) {
    const std::string part = path.substr(0, slash);
    struct stat found {};
    if (::lstat(part.c_str(), &found) != 0) return {};  // and nothing behind it, either
    if (S_ISLNK(found.st_mode) && found.st_uid != ::geteuid() && found.st_uid != 0)
      return fail(
          Fault::FileUnwritable,
          fmt::format("is a link that user {} has made, and is not followed; name another folder", found.st_uid), part);
    if (slash == std::string::npos) return {};
  }
}

Result<void> make_folder(const std::string& path) {
  if (auto ours = no_foreign_link(path); !ours) return ours;
  std::string name = path;
  while (name.size() > 1 && name.back() == '/') name.pop_back();  // a link with a slash behind it would be followed
  if (const auto slash = name.rfind('/'); slash != std::string::npos && slash > 0) {
    struct stat above {};
    if (::stat(name.substr(0, slash).c_str(), &above) != 0)
      if (auto made = make_folder(name.substr(0, slash)); !made) return made;
  }
  if (::mkdir(name.c_str(), 0777) == 0) return {};
  if (errno != EEXIST) return unwritable("the folder cannot be made", errno, name);
  struct stat found {
  }, target{};
  if (::lstat(name.c_str(), &found) != 0) return unwritable("the folder cannot be looked at", errno, name);
  if (S_ISDIR(found.st_mode)) return {};
  if (!S_ISLNK(found.st_mode)) return unwritable("there is something of this name that is no folder", ENOTDIR, name);
  if (::stat(name.c_str(), &target) != 0 || !S_ISDIR(target.st_mode))
    return unwritable("is a link that leads to no folder", ENOTDIR, name);
  return {};
}

Result<void> try_folder(const std::string& path) {
  std::string there = path;
  for (struct stat found{}; ::lstat(there.c_str(), &found) != 0 && errno == ENOENT;) {
    while (there.size() > 1 && there.back() == '/') there.pop_back();
    const auto slash = there.rfind('/');
    there = slash == std::string::npos ? "." : there.substr(0, std::max<std::size_t>(slash, 1));
  }
  if (auto is_one = make_folder(there); !is_one) return is_one;
  std::string trial = there + "/.gantry-XXXXXX";
  const int fd = ::mkstemp(trial.data());
  if (fd < 0)
    return errno == ENOSPC ? Result<void>{}
                           : unwritable(fmt::format("no file can be made in '{}'", there), errno, path);
  ::unlink(trial.c_str());
  ::close(fd);
  return {};
}

}  // namespace gantry
