// What recordings may replace.
#include <gtest/gtest.h>

#include <filesystem>

#include "service/base/files/whole_file.h"
#include "service/daemon/run.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_recordings {

TEST(Recordings, ExistingFileIsRefusedUnlessReplaced) {
  const test::TempFolder folder;
  RunOptions options{.device = "twin"};
  options.record_path = folder.Write("old.csv", "old");
  EXPECT_NE(OptionsProblem(options).find("--replace"), std::string::npos);
  options.replace = true;
  EXPECT_EQ(OptionsProblem(options), "");
  ASSERT_TRUE(MakeWay(options).ok());
  EXPECT_FALSE(std::filesystem::exists(options.record_path));
}

TEST(Recordings, BaseThatComesBackGetsAFileOfItsOwn) {
  const test::TempFolder folder;
  RunOptions options{.device = "twin"};
  options.record_device_path = folder.Path("base.rec");
  EXPECT_EQ(WithFreeNames(options).record_device_path, folder.Path("base.rec"));
  folder.Write("base.rec", "the first");
  EXPECT_EQ(WithFreeNames(options).record_device_path, folder.Path("base.rec.2"));
  folder.Write("base.rec.2", "the second");
  EXPECT_EQ(WithFreeNames(options).record_device_path, folder.Path("base.rec.3"));
}

TEST(NewFile, IsNeverMadeOverOneOrThroughALink) {
  const test::TempFolder folder;
  const std::string file = folder.Write("file", "content"), link = folder.Path("link"), loose = folder.Path("loose");
  std::filesystem::create_symlink(file, link);
  std::filesystem::create_symlink(folder.Path("nothing"), loose);
  for (const std::string& path : {file, link, loose, folder.Path()}) EXPECT_FALSE(base::MakeNewFile(path).ok()) << path;
  EXPECT_FALSE(std::filesystem::exists(folder.Path("nothing")));
  EXPECT_EQ(std::filesystem::file_size(file), 7U);
  EXPECT_TRUE(base::MakeNewFile(folder.Path("new")).ok());
  EXPECT_TRUE(base::MakeNewFile("/dev/null").ok()) << "loses nothing";
}

}  // namespace test_daemon_recordings
}  // namespace omni::daemon
