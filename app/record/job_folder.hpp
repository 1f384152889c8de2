// Where a job leaves its files.
//   auto folder = job_folder({.path = "out/first"}, recipe_file);   ...   write_job(result, folder->path);
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "app/record/job_result.hpp"
#include "app/record/room.hpp"

namespace gantry::record {

/// Writes what certifies the job, after its report and only beside it; empty: nothing does.
using Certify = std::function<Result<void>(const std::string& folder)>;

struct WantedFolder {
  std::string path{};  ///< empty: the first <under>/<recipe>-<n> behind all that have been there
  std::string under = "out";
  bool overwrite = false;              ///< what another job has left in `path` goes; nothing else does
  std::vector<std::string> made_of{};  ///< files of the new job, which stay even where another job has left them
};

/// A folder that one job writes into, as long as this lives: no other one clears it meanwhile (flock(2)).
class FolderInUse {
 public:
  FolderInUse() = default;
  /// Nothing while another job writes into it. A folder that is not there, or not to be read, is in nobody's use.
  static std::optional<FolderInUse> take(const std::string& folder);
  ~FolderInUse();
  FolderInUse(FolderInUse&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FolderInUse& operator=(FolderInUse&&) = delete;

 private:
  explicit FolderInUse(int fd) : fd_(fd) {}
  int fd_ = -1;
};

/// Where a job leaves its files, and the room on its disk that nobody else can take.
struct JobFolder {
  std::string path;
  KeptRoom room;
  FolderInUse in_use;
};

/// What is wrong with it is known before long work, and nothing is made: Fault::Usage (files cannot be made in the
/// wanted folder, or it holds a job, or one writes into it), FileUnwritable.
Result<void> check_folder(const WantedFolder& wanted);

/// The folder for a job's results, made, with room on its disk. Of a job that is overwritten goes what its summary
/// names and what every job leaves; nothing else, and nothing before there is room. Fault::Usage (a wanted folder
/// cannot be written, or holds a job), FileUnwritable.
Result<JobFolder> job_folder(const WantedFolder& wanted, const std::string& recipe_file, const Room& room = {});

/// The last name of the folder's path, however that was written ("out/first/", "."); "" of the root.
std::string name_of_job(const std::string& folder);

/// What a job has left in `folder`, and the folder where nothing else lies in it.
void take_away(const std::string& folder);

/// All files of the job that are written when it has ended: the summary, then the report, then the larger ones, and the
/// summary once more with the names of what is there. What cannot be written is told in result.not_kept; a file of
/// `marks` or `inputs` that was there before the job is not written over. The summary is made of the room that was kept
/// for it.
/// Fault::FileUnwritable: there is no summary.
Result<void> write_job(JobResult& result, const std::string& folder, const Certify& certify = {}, KeptRoom room = {});

/// Whether a job has left its report there.
bool has_report(const std::string& folder);

}  // namespace gantry::record
