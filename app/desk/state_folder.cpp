#include "app/desk/state_folder.hpp"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/absolute_path.hpp"
#include "core/new_file.hpp"

namespace gantry::desk {
namespace {

namespace fs = std::filesystem;

/// A machine's name as the name of a folder: it comes from a file that people write.
std::string as_folder_name(std::string name) {
  for (char& c : name)
    if (c == '/' || c == '\0') c = '-';
  return name.empty() || name == "." || name == ".." ? "machine" : name;
}

constexpr struct {
  std::string_view what, remedy;
} kNoFolder{"the state folder is a link or no folder", "name the folder itself with --state"};

/// Whether closing it to others can surprise nobody: it is empty, or an owner has used it before.
bool is_for_state(const fs::path& path) {
  std::error_code error;
  return fs::is_empty(path, error) || fs::exists(path / "owner.sock.lock", error);
}

}  // namespace

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<std::string> state_folder(const std::string& option, const std::string& machine_name, const Environment& env) {
  const auto absolute = [](const fs::path& path) {
    auto text =
        absolute_path(path.string()).map([](const std::string& p) { return fs::path(p).lexically_normal().string(); });
    // A link with a slash behind it would be followed.
    if (text && text->size() > 1 && text->back() == '/') text->pop_back();
    return text;
  };
  if (!option.empty()) return absolute(option);
  if (const std::string named = env("GANTRY_STATE"); !named.empty()) return absolute(named);
  const std::string name = as_folder_name(machine_name);
  // The XDG base directory specification: a relative path is invalid and is ignored.
  if (const fs::path xdg = env("XDG_STATE_HOME"); xdg.is_absolute()) return absolute(xdg / "gantry" / name);
  if (const fs::path home = env("HOME"); home.is_absolute()) return absolute(home / ".local/state/gantry" / name);
  return fail(Fault::Usage, "there is no home folder for the machine's state; name one with --state or GANTRY_STATE",
              "--state");
}

std::string shared_socket(const std::string& option, const Environment& env) {
  if (!option.empty() || !env("GANTRY_STATE").empty()) return "";
  const std::string named = env("GANTRY_SOCKET");
  return named.empty() ? kSharedSocket : named;
}

std::optional<UnfitFolder> unfit_for_state(const std::string& path, const struct stat& found) {
  const auto shut = [&] { return fmt::format("run `chmod 700 {}`, or name another one with --state", path); };
  const unsigned mode = found.st_mode & 07777u;
  if (!S_ISDIR(found.st_mode)) return UnfitFolder{std::string(kNoFolder.what), std::string(kNoFolder.remedy)};
  if (found.st_uid != ::geteuid())
    return UnfitFolder{
        fmt::format("the state folder belongs to user {}, and you are user {}", found.st_uid, ::geteuid()),
        "name one of your own with --state"};
  if ((mode & 022u) != 0)
    return UnfitFolder{fmt::format("other users may write to the state folder (mode {:04o})", mode), shut()};
  if ((mode & 0777u) != 0700 && !is_for_state(path))
    return UnfitFolder{fmt::format("other users may look into this folder (mode {:04o}), and it holds other things "
                                   "than state",
                                   mode),
                       shut()};
  return std::nullopt;
}

Result<void> look_at_state_folder(const std::string& path) {
  struct stat found {};
  const bool there = ::stat(path.c_str(), &found) == 0;
  if (there ? S_ISDIR(found.st_mode) : errno == ENOENT) return {};
  return fail(Fault::Refused,
              there || errno == ENOTDIR ? std::string(kNoFolder.what) + "; " + std::string(kNoFolder.remedy)
                                        : fmt::format("the state folder cannot be looked at: {}", std::strerror(errno)),
              path);
}

Result<void> open_state_folder(const std::string& path) {
  if (auto ours = no_foreign_link(fs::path(path).parent_path().string()); !ours) return ours;
  std::error_code error;
  if (const fs::path above = fs::path(path).parent_path(); !fs::is_directory(above, error)) {
    const mode_t old_mask = ::umask(0077);
    fs::create_directories(above, error);
    ::umask(old_mask);
    if (error)
      return fail(Fault::FileUnwritable, fmt::format("the folder above cannot be made: {}", error.message()), path);
  }
  if (::mkdir(path.c_str(), 0700) != 0 && errno != EEXIST)
    return fail(Fault::FileUnwritable, fmt::format("the state folder cannot be made: {}", std::strerror(errno)), path);
  const int fd = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
  if (fd < 0) {
    const int why = errno;
    if (why == ENOTDIR || why == ELOOP)
      return fail(Fault::Refused, std::string(kNoFolder.what) + "; " + std::string(kNoFolder.remedy), path);
    return fail(Fault::Refused, fmt::format("the state folder cannot be opened: {}", std::strerror(why)), path);
  }
  struct stat found {};
  Result<void> done;
  if (::fstat(fd, &found) != 0)
    done = fail(Fault::Refused, fmt::format("the state folder cannot be looked at: {}", std::strerror(errno)), path);
  else if (const auto unfit = unfit_for_state(path, found))
    done = fail(Fault::Refused, unfit->what + "; " + unfit->remedy, path);
  else if ((found.st_mode & 0777u) != 0700 && ::fchmod(fd, 0700) != 0)
    done = fail(Fault::FileUnwritable, fmt::format("its mode cannot be set: {}", std::strerror(errno)), path);
  ::close(fd);
  return done;
}

}  // namespace gantry::desk
