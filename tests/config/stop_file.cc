// The latch of an emergency stop: whatever is at its path means stopped.
#include "service/config/files/stop_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>

#include "service/config/text/text_file.h"
#include "tests/support/process/temp_folder.h"

namespace omni::config {
namespace test_config_stop_file {

namespace fs = std::filesystem;

class StopFile : public testing::Test {
 protected:
  test::TempFolder folder_;
  const std::string path_ = folder_.Path("state/omni/emergency_stop.toml");
};

TEST_F(StopFile, WrittenRecordIsReadBack) {
  EXPECT_FALSE(FindStop(path_).has_value());
  ASSERT_TRUE(KeepStop(path_, {.by = "omni \"stop\"", .at = "2026-01-31T12:00:00Z"}).ok());
  const auto found = FindStop(path_);
  ASSERT_TRUE(found.has_value());
  EXPECT_EQ(found->by, "omni \"stop\"");
  EXPECT_EQ(found->at, "2026-01-31T12:00:00Z");
  ASSERT_TRUE(RemoveStop(path_).ok());
  EXPECT_FALSE(FindStop(path_).has_value());
  EXPECT_TRUE(RemoveStop(path_).ok()) << "nothing to remove";
}

TEST_F(StopFile, LatchThatIsThereIsKept) {
  ASSERT_TRUE(KeepStop(path_, {.by = "first", .at = "2026-01-31T12:00:00Z"}).ok());
  ASSERT_TRUE(KeepStop(path_, {.by = "second", .at = "2026-01-31T13:00:00Z"}).ok());
  EXPECT_EQ(FindStop(path_)->by, "first");
}

TEST_F(StopFile, IsoTimeIsUtc) {
  EXPECT_EQ(IsoTime(0), "1970-01-01T00:00:00Z");
  EXPECT_EQ(IsoTime(1'769'860'800), "2026-01-31T12:00:00Z");
}

TEST_F(StopFile, WithoutHomeThereIsNoLatch) {
  EXPECT_FALSE(FindStop("").has_value());
  EXPECT_FALSE(KeepStop("", {}).ok());
  EXPECT_TRUE(RemoveStop("").ok());
}

// Each with the time of its last change.
TEST_F(StopFile, WhateverIsThereMeansStopped) {
  fs::create_directories(fs::path(path_).parent_path());
  const auto expect_stopped = [&](const char* what) {
    SCOPED_TRACE(what);
    const auto found = FindStop(path_);
    ASSERT_TRUE(found.has_value());
    EXPECT_EQ(found->by, "");
    EXPECT_EQ(found->at.size(), std::string("2026-01-31T12:00:00Z").size()) << found->at;
    fs::remove_all(path_);
  };
  ASSERT_TRUE(WriteTextFile(path_, "").ok());
  expect_stopped("an empty file");
  ASSERT_TRUE(WriteTextFile(path_, std::string("\0\xff[[[=", 6)).ok());
  expect_stopped("garbage");
  ASSERT_TRUE(WriteTextFile(path_, "by = 7\nat = [1]\n").ok());
  expect_stopped("other types");
  ASSERT_TRUE(WriteTextFile(path_, std::string(1'000'000, '[')).ok());
  expect_stopped("a long file");
  fs::create_directory(path_);
  expect_stopped("a folder");
  fs::create_symlink(folder_.Path("not there"), path_);
  expect_stopped("a link to nothing");
  fs::create_symlink(path_, path_);
  expect_stopped("a link to itself");
  ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
  expect_stopped("a pipe");
  ASSERT_TRUE(WriteTextFile(path_, "by = \"x\"\n").ok());
  fs::permissions(path_, fs::perms::none);
  if (geteuid() != 0) expect_stopped("an unreadable file");
}

TEST_F(StopFile, RemovingALinkLeavesItsTarget) {
  const std::string target = folder_.Write("target", "x");
  fs::create_directories(fs::path(path_).parent_path());
  fs::create_symlink(target, path_);
  ASSERT_TRUE(RemoveStop(path_).ok());
  EXPECT_FALSE(FindStop(path_).has_value());
  EXPECT_TRUE(fs::exists(target));
}

TEST_F(StopFile, FolderCannotBeRemovedAndTheErrorNamesIt) {
  fs::create_directories(path_);
  const base::Status removed = RemoveStop(path_);
  ASSERT_FALSE(removed.ok());
  EXPECT_EQ(removed.error().rfind(path_ + ": cannot be removed: ", 0), 0U) << removed.error();
  EXPECT_TRUE(FindStop(path_).has_value());
}

}  // namespace test_config_stop_file
}  // namespace omni::config
