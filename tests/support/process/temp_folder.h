// A temporary folder of a test, removed with it.
#pragma once

#include <stdlib.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

namespace omni::test {

class TempFolder {
 public:
  TempFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "omni-test-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) std::abort();
    path_ = name;
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::string Path(const std::string& below = {}) const { return below.empty() ? path_ : path_ + "/" + below; }

  // Makes the folders it needs; the file's path.
  std::string Write(const std::string& below, std::string_view content) const {
    const std::filesystem::path file = Path(below);
    std::filesystem::create_directories(file.parent_path());
    // Some file systems flush a file that is truncated and written again: thousands of times, that takes minutes.
    std::filesystem::remove(file);
    std::ofstream stream(file, std::ios::binary);
    stream << content;
    if (!stream.flush()) std::abort();
    return file.string();
  }

 private:
  std::string path_;
};

}  // namespace omni::test
