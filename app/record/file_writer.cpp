#include "app/record/file_writer.hpp"

#include <utility>

namespace gantry::record {

Result<std::unique_ptr<FileWriter>> FileWriter::create(const std::string& path, Thread thread) {
  auto file = NewFile::create(path);
  if (!file) return tl::unexpected(file.error());
  std::unique_ptr<FileWriter> writer(new FileWriter(std::move(*file)));
  if (thread == Thread::Own) writer->thread_ = std::thread([w = writer.get()] { w->serve(); });
  return writer;
}

FileWriter::~FileWriter() { end_thread(); }

void FileWriter::write(std::string bytes) {
  if (!thread_.joinable()) return put(bytes);
  {
    const std::lock_guard lock(mutex_);
    if (too_slow_ || queued_ + bytes.size() > kLongestQueue) return void(too_slow_ = true);
    queued_ += bytes.size();
    queue_.push_back(std::move(bytes));
  }
  more_.notify_one();
}

void FileWriter::put(const std::string& bytes) {
  if (file_.failed()) return;
  file_.write(bytes);
  if (file_.failed()) file_.discard();
}

void FileWriter::serve() {
  std::unique_lock lock(mutex_);
  for (;;) {
    more_.wait(lock, [this] { return ends_ || !queue_.empty(); });
    if (queue_.empty()) return;
    const std::string bytes = std::move(queue_.front());
    queue_.pop_front();
    lock.unlock();
    put(bytes);
    lock.lock();
    queued_ -= bytes.size();
  }
}

void FileWriter::end_thread() {
  if (!thread_.joinable()) return;
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  more_.notify_one();
  thread_.join();
}

Result<void> FileWriter::close() {
  end_thread();
  auto closed = file_.close();
  if (closed && too_slow_)
    closed = fail(Fault::FileUnwritable, "the disk is too slow: the file could not be kept up with");
  if (!closed) file_.discard();
  return closed;
}

}  // namespace gantry::record
