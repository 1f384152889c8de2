#include "app/record/write_file.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace gantry::record {

Result<void> write_file(const std::string& path, std::string_view bytes) {
  namespace fs = std::filesystem;
  const fs::path target(path);
  std::error_code error;
  if (target.has_parent_path()) fs::create_directories(target.parent_path(), error);
  if (error) return fail(Fault::FileUnwritable, "the folder cannot be made: " + error.message(), path);

  const std::string beside = path + ".part";
  std::ofstream out(beside, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (!out) {
    const std::string why = std::strerror(errno);
    fs::remove(beside, error);
    return fail(Fault::FileUnwritable, "the file cannot be written: " + why, path);
  }
  fs::rename(beside, target, error);
  if (error) return fail(Fault::FileUnwritable, "the file cannot be put in place: " + error.message(), path);
  return {};
}

}  // namespace gantry::record
