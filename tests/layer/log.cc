// The layer's log: where it may be written, and what a line may contain.
#include "layer/src/instance/log.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <string>

#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_log {

std::string Content(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class LayerLog : public testing::Test {
 protected:
  const TempFolder temp;
  const std::string file = temp.Path("log");
};

TEST_F(LayerLog, LinesAreAppended) {
  temp.Write("log", "before\n");
  layer::Log(file).WriteLine("one");
  layer::Log(file).WriteLine("two");
  EXPECT_EQ(Content(file), "before\nomni layer: one\nomni layer: two\n");
}

TEST_F(LayerLog, EmptyOrZeroPathWritesNothing) {
  for (const char* where : {"", "0"}) layer::Log(where).WriteLine("one");
  EXPECT_NE(::access(file.c_str(), F_OK), 0);
}

// The name of an application or a runtime must not look like a line of its own.
TEST_F(LayerLog, ControlCharactersCannotForgeALine) {
  layer::Log(file).WriteLine("one\nomni layer: two\x1b[31m\r\x80\xC2\x9B end");
  EXPECT_EQ(Content(file),
            "omni layer: one?omni layer: two?[31m???"
            "? end\n");
}

TEST_F(LayerLog, NewFileIsPrivateToTheUser) {
  const mode_t before = ::umask(0);
  layer::Log(file).WriteLine("one");
  ::umask(before);
  struct stat info {};
  ASSERT_EQ(::stat(file.c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 07777u, 0600u);
}

TEST_F(LayerLog, SymlinksAreNotFollowed) {
  const std::string target = temp.Write("target", "before\n");
  ASSERT_EQ(::symlink(target.c_str(), file.c_str()), 0);
  layer::Log(file).WriteLine("one");
  EXPECT_EQ(Content(target), "before\n");
}

// It neither waits for a reader nor writes to one.
TEST_F(LayerLog, FifosAndDirectoriesAreRejected) {
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  layer::Log(file).WriteLine("one");
  const int reader = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  ASSERT_GE(reader, 0);
  layer::Log(file).WriteLine("two");
  char byte = 0;
  EXPECT_EQ(::read(reader, &byte, 1), 0) << "nothing was written";
  ::close(reader);
  layer::Log(temp.Path()).WriteLine("three");
  layer::Log("/dev/full").WriteLine("four");
}

}  // namespace test_log
}  // namespace omni::test
