// Files are written off the control thread: it never waits, the newest text counts, the destructor waits briefly.
#include "service/daemon/file_writer.h"

#include <gtest/gtest.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace omni::daemon {
namespace test_daemon_file_writer {

// A disk that a test can block. Shared with the writer's thread, which may outlive the writer.
struct Disk {
  std::mutex mutex;
  std::condition_variable changed;
  bool open = true;
  bool full = false;
  int begun = 0, left = 0;
  std::vector<std::pair<std::string, std::string>> files;

  base::Status Write(const std::string& path, const std::string& text) {
    std::unique_lock lock(mutex);
    ++begun;
    changed.notify_all();
    changed.wait(lock, [this] { return open; });
    files.emplace_back(path, text);
    ++left;
    changed.notify_all();
    if (full) return base::Error{path + ": cannot be written: no space left"};
    return base::Ok{};
  }
  void Set(bool now_open) {
    const std::lock_guard lock(mutex);
    open = now_open;
    changed.notify_all();
  }
  void WaitUntilBegun(int count) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return begun >= count; });
  }
  void WaitUntilLeft(int count) {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return left >= count; });
  }
};

FileWriter::Write On(const std::shared_ptr<Disk>& disk) {
  return [disk](const std::string& path, const std::string& text) { return disk->Write(path, text); };
}

FileWriter::Written Next(FileWriter& writer) {
  while (true) {
    if (auto written = writer.PopWritten()) return *written;
    std::this_thread::yield();
  }
}

TEST(DaemonFileWriter, WritesOnlyTheNewestWaitingText) {
  const auto disk = std::make_shared<Disk>();
  FileWriter writer(On(disk));
  disk->Set(false);
  EXPECT_EQ(writer.RequestWrite("a", "1"), 1U);
  disk->WaitUntilBegun(1);
  for (int i = 2; i <= 50; ++i) EXPECT_EQ(writer.RequestWrite("a", std::to_string(i)), static_cast<std::uint64_t>(i));
  EXPECT_EQ(writer.RequestWrite("b", "other"), 51U);
  EXPECT_FALSE(writer.PopWritten()) << "the disk has not responded, and no call has waited for it";
  disk->Set(true);
  EXPECT_EQ(Next(writer).number, 1U);
  EXPECT_EQ(Next(writer).number, 50U) << "and with it all before";
  EXPECT_EQ(Next(writer).path, "b");
  EXPECT_EQ(disk->files, (std::vector<std::pair<std::string, std::string>>{{"a", "1"}, {"a", "50"}, {"b", "other"}}));
}

TEST(DaemonFileWriter, AFailedWriteIsReportedAndTheNextIsTried) {
  const auto disk = std::make_shared<Disk>();
  disk->full = true;
  FileWriter writer(On(disk));
  writer.RequestWrite("a", "1");
  const FileWriter::Written failed = Next(writer);
  ASSERT_FALSE(failed.status.ok());
  EXPECT_NE(failed.status.error().find("no space left"), std::string::npos);
  disk->full = false;
  writer.RequestWrite("a", "2");
  EXPECT_TRUE(Next(writer).status.ok());
}

TEST(DaemonFileWriter, DestructorWritesWaitingTexts) {
  const auto disk = std::make_shared<Disk>();
  {
    FileWriter writer(On(disk));
    for (int i = 0; i < 20; ++i) writer.RequestWrite("file " + std::to_string(i), "x");
  }
  EXPECT_EQ(disk->files.size(), 20U);
  const FileWriter idle(On(disk));  // no request: no thread to end
}

TEST(DaemonFileWriter, HangingDiskDoesNotBlockTheDestructor) {
  const auto disk = std::make_shared<Disk>();
  disk->Set(false);
  {
    FileWriter writer(On(disk));
    writer.RequestWrite("a", "1");
    disk->WaitUntilBegun(1);
  }
  EXPECT_EQ(disk->left, 0) << "abandoned";
  disk->Set(true);
  disk->WaitUntilLeft(1);
}

}  // namespace test_daemon_file_writer
}  // namespace omni::daemon
