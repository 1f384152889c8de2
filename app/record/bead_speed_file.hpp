// The speed of the needle along each bead as it was commanded, over time: what a flow could follow.
//   BeadSpeedFile file("out/job/bead_speeds.csv", recipe, start_ns);   file.add(snapshot); ...   file.close();
// A row stands where the speed has changed by more than kChange of the material's since the row before, where the valve
// was opened or shut, and where the bead begins and ends, run-up and run-out included. The speed is that of the path;
// the drives follow it by their delay, by which the valve is delayed, too.
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "app/cycle/channels.hpp"
#include "app/record/file_writer.hpp"
#include "core/error.hpp"
#include "motion/types.hpp"
#include "recipes/recipe.hpp"

namespace gantry::record {

class BeadSpeedFile {
 public:
  static constexpr double kChange = 0.005;

  /// `recipe` outlives it; times count from start_ns.
  BeadSpeedFile(const std::string& path, const recipes::Recipe& recipe, std::int64_t start_ns,
                FileWriter::Thread thread = FileWriter::Thread::Callers)
      : out_(std::make_unique<FileWriter>(path, thread)), recipe_(&recipe), start_ns_(start_ns) {}
  /// Takes what belongs to a bead, leaves the rest.
  void add(const cycle::Snapshot& snapshot);
  /// Says whether everything reached the file. Fault::FileUnwritable: then there is none.
  Result<void> close();

 private:
  struct Row {
    std::uint32_t block = 0, feature = motion::kTravel;
    double t_s = 0, speed_mm_s = 0;
    bool valve = false;
  };
  void write(const Row& row);

  std::unique_ptr<FileWriter> out_;
  std::string rows_ = "feature,t_s,speed_mm_s,valve\n";  ///< not handed to the writer yet
  const recipes::Recipe* recipe_;
  std::int64_t start_ns_;
  Row seen_, written_;
  double change_mm_s_ = 0;  ///< of the bead that is seen: what makes a row
};

}  // namespace gantry::record
