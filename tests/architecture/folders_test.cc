// A folder of code stays small enough to be looked over: docs/architecture.md, "Folders".
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFiles = 30;

// Folder -> how many files of code it holds itself.
std::map<std::string, int> FilesByFolder(const std::string& root, const std::vector<std::string>& tops) {
  std::map<std::string, int> files;
  for (const auto& [path, text] : ReadTree(root, tops, {".c", ".cc", ".cpp", ".h", ".hpp", ".py", ".ts"}))
    ++files[path.substr(0, path.rfind('/'))];
  return files;
}

TEST(Folders, HoldAtMostThirtyFilesOfCode) {
  const auto files =
      FilesByFolder(OMNI_SOURCE_DIR, {"firmware", "layer", "manifests", "scenes", "scripts", "service", "tests"});
  ASSERT_GT(files.size(), 100U) << "the sources were found";
  for (const auto& [folder, count] : files)
    EXPECT_LE(count, kMostFiles) << folder << ": divide it by topic, with names that say the topic";
}

TEST(Folders, CountIncludesOnlyCodeOfTheFolderItself) {
  const fs::path root = fs::path(testing::TempDir()) / "omni_folders_test";
  fs::create_directories(root / "service/a/b");
  for (const char* name : {"service/a/x.cc", "service/a/x.h", "service/a/notes.md", "service/a/b/y.cc"})
    fclose(fopen((root / name).c_str(), "w"));
  const auto files = FilesByFolder(root.string(), {"service"});
  EXPECT_EQ(files.at("service/a"), 2);
  EXPECT_EQ(files.at("service/a/b"), 1);
  fs::remove_all(root);
}

}  // namespace
}  // namespace omni::architecture
