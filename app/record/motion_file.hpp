// motions.csv: every motion that was proved and played, one a row (job/motion_rows.hpp). It stands beside
// certificate.json, which names its hash.
//   MotionFile file("out/job/motions.csv", machine);   file.add(block); ...   auto listed = file.close();
#pragma once
#include <memory>
#include <string>

#include "app/job/proven_block.hpp"
#include "app/record/file_writer.hpp"
#include "app/record/job_result.hpp"
#include "config/machine.hpp"
#include "core/error.hpp"
#include "core/sha256.hpp"

namespace gantry::record {

inline constexpr const char* kMotionFile = "motions.csv";

class MotionFile {
 public:
  MotionFile(const std::string& path, const config::Machine& machine,
             FileWriter::Thread thread = FileWriter::Thread::Callers);
  /// A block that lists its motions.
  void add(const job::ProvenBlock& block);
  /// Waits for the disk. Fault::FileUnwritable: then there is no file.
  Result<MotionsListed> close();

 private:
  void write(const std::string& rows);

  std::unique_ptr<FileWriter> out_;
  Sha256 hash_;
  std::size_t count_ = 0;
};

}  // namespace gantry::record
