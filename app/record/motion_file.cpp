#include "app/record/motion_file.hpp"

#include "app/job/motion_rows.hpp"
#include "core/clean_text.hpp"

namespace gantry::record {

MotionFile::MotionFile(const std::string& path, const config::Machine& machine, FileWriter::Thread thread)
    : out_(std::make_unique<FileWriter>(path, thread)) {
  write(job::MotionRows(machine).heading());
}

void MotionFile::write(const std::string& raw) {
  const std::string rows = clean_lines(raw);  // names of files are in them
  hash_.add(rows);
  out_->write(rows);
}

void MotionFile::add(const job::ProvenBlock& block) {
  for (const std::string& rows : block.rows()) write(rows);
  count_ += block.motions();
}

Result<MotionsListed> MotionFile::close() {
  if (auto closed = out_->close(); !closed) return tl::unexpected(closed.error());
  return MotionsListed{count_, hash_.hex()};
}

}  // namespace gantry::record
