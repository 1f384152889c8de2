#include "app/record/file_writer.hpp"

#include <utility>

namespace gantry::record {

FileWriter::FileWriter(std::string path, Thread thread) : path_(std::move(path)) {
  if (thread == Thread::Own)
    thread_ = std::thread([this] { serve(); });
  else
    open();
}

FileWriter::~FileWriter() { end_thread(); }

void FileWriter::open() {
  auto file = NewFile::create(path_);
  if (file)
    file_.emplace(std::move(*file));
  else
    done_ = tl::unexpected(file.error());
}

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
  if (!file_ || file_->failed()) return;
  file_->write(bytes);
  if (file_->failed()) file_->discard();
}

void FileWriter::finish() {
  if (!file_) return;
  done_ = file_->close();
  if (done_ && too_slow_)
    done_ = fail(Fault::FileUnwritable, "the disk is too slow: the file could not be kept up with");
  if (!done_) file_->discard();
  file_.reset();
}

void FileWriter::serve() {
  open();
  std::unique_lock lock(mutex_);
  for (;;) {
    more_.wait(lock, [this] { return ends_ || !queue_.empty(); });
    if (queue_.empty()) return finish();
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
  if (thread_.joinable())
    end_thread();
  else
    finish();
  return done_;
}

}  // namespace gantry::record
