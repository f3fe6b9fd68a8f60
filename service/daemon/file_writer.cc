#include "service/daemon/file_writer.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/threads/realtime_threads.h"

namespace omni::daemon {

struct FileWriter::Shared {
  struct Job {
    std::uint64_t number = 0;
    std::string text;
  };

  explicit Shared(Write how) : write(std::move(how)) {}

  void Run() {
    std::unique_lock<std::mutex> lock(mutex);
    while (true) {
      wake.wait(lock, [this] { return !waiting.empty() || ending; });
      if (waiting.empty()) break;
      const auto [path, job] = *waiting.begin();
      waiting.erase(waiting.begin());
      lock.unlock();
      Written one{job.number, path, Try(path, job.text)};
      lock.lock();
      written.push_back(std::move(one));
    }
    ended = true;
    wake.notify_all();
  }

  base::Status Try(const std::string& path, const std::string& text) const {
    try {
      return write(path, text);
    } catch (const std::exception& caught) {  // out of memory
      return base::Error{path + ": cannot be written: " + caught.what()};
    }
  }

  const Write write;
  base::PriorityMutex mutex;
  std::condition_variable wake;
  std::map<std::string, Job> waiting;  // by path
  std::deque<Written> written;
  std::uint64_t requested = 0;
  bool started = false, ending = false, ended = false;
};

FileWriter::FileWriter(Write write) : shared_(std::make_shared<Shared>(std::move(write))) {}

FileWriter::~FileWriter() {
  std::unique_lock<std::mutex> lock(shared_->mutex);
  shared_->ending = true;
  shared_->wake.notify_all();
  const bool done = !shared_->started || shared_->wake.wait_for(lock, kPatience, [this] { return shared_->ended; });
  if (!done) spdlog::error("the disk does not respond: the last changes are not saved");
  for (const Written& one : shared_->written) {
    if (!one.status.ok()) spdlog::error("{}", one.status.error());
  }
}

std::uint64_t FileWriter::RequestWrite(const std::string& path, std::string text) {
  const std::lock_guard lock(shared_->mutex);
  const std::uint64_t number = ++shared_->requested;
  shared_->waiting[path] = {number, std::move(text)};
  if (!shared_->started) std::thread([shared = shared_] { shared->Run(); }).detach();
  shared_->started = true;
  shared_->wake.notify_all();
  return number;
}

std::optional<FileWriter::Written> FileWriter::PopWritten() {
  const std::lock_guard lock(shared_->mutex);
  if (shared_->written.empty()) return std::nullopt;
  Written one = std::move(shared_->written.front());
  shared_->written.pop_front();
  return one;
}

}  // namespace omni::daemon
