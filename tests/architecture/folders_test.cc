// A folder of code stays small enough to be looked over: docs/architecture.md, "Folders".
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <string>

namespace omni::architecture {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFiles = 30;

// Folder -> how many files of code it holds itself, below `root`.
std::map<std::string, int> FilesByFolder(const fs::path& root) {
  const std::set<std::string> code{".c", ".cc", ".cpp", ".h", ".hpp", ".py", ".ts"};
  std::map<std::string, int> files;
  for (const char* top : {"firmware", "layer", "manifests", "scenes", "scripts", "service", "tests"}) {
    if (!fs::exists(root / top)) continue;
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (entry.is_regular_file() && code.count(entry.path().extension().string()) != 0)
        ++files[fs::relative(entry.path().parent_path(), root).generic_string()];
    }
  }
  return files;
}

TEST(Folders, HoldAtMostThirtyFilesOfCode) {
  const auto files = FilesByFolder(OMNI_SOURCE_DIR);
  ASSERT_GT(files.size(), 100U) << "the sources were found";
  for (const auto& [folder, count] : files)
    EXPECT_LE(count, kMostFiles) << folder << ": divide it by topic, with names that say the topic";
}

TEST(Folders, CountIncludesOnlyCodeOfTheFolderItself) {
  const fs::path root = fs::path(testing::TempDir()) / "omni_folders_test";
  fs::create_directories(root / "service/a/b");
  for (const char* name : {"service/a/x.cc", "service/a/x.h", "service/a/notes.md", "service/a/b/y.cc"})
    fclose(fopen((root / name).c_str(), "w"));
  const auto files = FilesByFolder(root);
  EXPECT_EQ(files.at("service/a"), 2);
  EXPECT_EQ(files.at("service/a/b"), 1);
  fs::remove_all(root);
}

}  // namespace
}  // namespace omni::architecture
