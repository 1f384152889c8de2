// A file that was not there before: nobody can have put a link in its place, and what stood under its name is replaced
// and never written through.
//   auto file = NewFile::create("out/job/setpoints.bin");   file->write(bytes);   file->close();
//   make_folder("out/job/marks");
#pragma once
#include <string>
#include <string_view>

#include "core/error.hpp"

namespace gantry {

class NewFile {
 public:
  /// Removes the file or link that has this name (a link itself, never its target; nothing else) and creates the file
  /// exclusively (open(2), O_EXCL and O_NOFOLLOW), readable for everybody as the umask allows. No foreign link leads to
  /// its folder. Fault::FileUnwritable.
  static Result<NewFile> create(const std::string& path);
  ~NewFile();
  NewFile(NewFile&& other) noexcept;
  NewFile& operator=(NewFile&&) = delete;

  /// Buffered. What goes wrong is reported by close().
  void write(std::string_view bytes);
  /// Everything so far is on the disk when this returns (fsync(2)); what goes wrong is reported by close().
  void sync();
  /// Something has not reached the file; what comes behind it does not, either.
  [[nodiscard]] bool failed() const { return failed_ != 0; }
  /// Takes the file away again: its room is free.
  void discard();
  /// Whether everything has reached the file. Fault::FileUnwritable.
  Result<void> close();

 private:
  NewFile(std::string path, int fd) : path_(std::move(path)), fd_(fd) {}
  void flush();

  std::string path_, buffer_;
  int fd_ = -1;
  int failed_ = 0;  ///< errno of the first write that failed
};

/// Writes beside `path` and renames into place: the file appears whole or not at all, and a link of this name is
/// replaced, not followed. Fault::FileUnwritable.
Result<void> write_new_file(const std::string& path, std::string_view bytes);

/// The same, of a file without a name (open(2), O_TMPFILE) of that file system: within what is allocated for it a full
/// disk prevents nothing, and what is allocated beyond `bytes` is given back. Fault::FileUnwritable.
Result<void> name_new_file(int nameless, const std::string& path, std::string_view bytes);

/// As write_new_file, and it survives a power cut from here on: file and folder are on the disk when this returns.
Result<void> write_durable_file(const std::string& path, std::string_view bytes);

/// No part of the path is a link that another user than this one or root has made: nobody else decides where files go.
/// Fault::FileUnwritable, naming the link.
Result<void> no_foreign_link(const std::string& path);

/// Makes the folder if it is not there; missing folders above it too. No foreign link is followed.
/// Fault::FileUnwritable.
Result<void> make_folder(const std::string& path);

/// Whether that could be done and files be made there, as far as can be told without leaving anything: tries it in the
/// folder, or in the nearest one above it that is there. A full disk is none of its business. Fault::FileUnwritable.
Result<void> try_folder(const std::string& path);

}  // namespace gantry
