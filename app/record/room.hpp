// Room on the disk for a job's results (R69): looked at before the job, and the part that must not be lost is kept free
// while it runs, whoever fills the disk meanwhile.
//   const Room room = room_for(forecast, recipe, cycle_s);
//   enough_room("out/job", room);   auto kept = KeptRoom::keep("out/job", room.result_bytes);
//   ...   kept->become("out/job/summary.json", text);
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "app/job/forecast.hpp"
#include "core/error.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

struct Room {
  std::uint64_t result_bytes = 0;  ///< summary.json and report.html
  std::uint64_t large_bytes = 0;   ///< setpoints.bin, deposits.csv, motions.csv and the images of the marks
};

/// More than such a job has ever needed, by its features, its duration and the motions that it lists.
Room room_for(const job::Forecast& forecast, const recipes::Recipe& recipe, double cycle_s,
              std::size_t listed_motions = 0);

/// In `folder`, or where it will be made. Fault::FileUnwritable: says how much is needed, and how to make room.
Result<void> enough_room(const std::string& folder, const Room& room);

/// Bytes of a disk that nobody else can have until they become a file, are given back, or the program ends. A file
/// without a name holds them.
class KeptRoom {
 public:
  KeptRoom() = default;
  /// Fault::FileUnwritable: there are not so many. Where the file system cannot promise room, none is kept.
  static Result<KeptRoom> keep(const std::string& folder, std::uint64_t bytes);
  ~KeptRoom() { give(); }
  KeptRoom(KeptRoom&& other) noexcept;
  KeptRoom& operator=(KeptRoom&&) = delete;

  /// They become the file of this name, which appears whole or not at all, and whoever fills the disk meanwhile cannot
  /// prevent it; what is too many is given back. Where none are kept, or too few, as any new file is written.
  /// Fault::FileUnwritable.
  Result<void> become(const std::string& path, std::string_view bytes);

  void give();

 private:
  explicit KeptRoom(int fd, std::uint64_t bytes = 0) : fd_(fd), bytes_(bytes) {}

  int fd_ = -1;
  std::uint64_t bytes_ = 0;
};

}  // namespace gantry::record
