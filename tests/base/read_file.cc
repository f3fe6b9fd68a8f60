// Arbitrary files are read up to a limit without blocking.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <string>

#include "service/base/files/whole_file.h"
#include "tests/support/process/temp_folder.h"

namespace omni::base {
namespace test_base_read_file {

void ExpectRefused(const std::string& path, std::size_t max_bytes, const char* why) {
  const Result<std::string> text = ReadFile(path, max_bytes);
  ASSERT_FALSE(text.ok()) << path;
  EXPECT_EQ(text.error().rfind(path + ": ", 0), 0U) << text.error();
  EXPECT_NE(text.error().find(why), std::string::npos) << text.error();
}

TEST(ReadFile, ReadsARegularFileWithinTheLimit) {
  const test::TempFolder folder;
  const std::string path = folder.Write("text", std::string("a\0b", 3));
  const Result<std::string> text = ReadFile(path, 3);
  ASSERT_TRUE(text.ok()) << text.error();
  EXPECT_EQ(*text, std::string("a\0b", 3));
  ExpectRefused(path, 2, "is longer than 2 bytes, the limit");
  const Result<std::string> empty = ReadFile(folder.Write("empty", ""), 10);
  ASSERT_TRUE(empty.ok()) << empty.error();
  EXPECT_EQ(*empty, "");
}

// Kernel files report a size of zero.
TEST(ReadFile, ReadsProcFilesWithUnknownSize) {
  const Result<std::string> text = ReadFile("/proc/self/status", 1 << 16);
  ASSERT_TRUE(text.ok()) << text.error();
  EXPECT_GT(text->size(), 500U);
  ExpectRefused("/proc/self/status", 100, "is longer than 100 bytes");
}

TEST(ReadFile, RejectsNonRegularFilesWithoutBlocking) {
  const test::TempFolder folder;
  ASSERT_EQ(mkfifo(folder.Path("pipe").c_str(), 0600), 0);
  ExpectRefused(folder.Path("pipe"), 10, "is not a regular file");
  ExpectRefused(folder.Path(), 10, "is not a regular file");
  ExpectRefused("/dev/zero", 10, "is not a regular file");
  ExpectRefused(folder.Path("missing"), 10, "cannot be read (No such file");
}

}  // namespace test_base_read_file
}  // namespace omni::base
