// Writes the user's files on a thread of its own: syncing a file waits for a disk, and the control thread must not. Of
// several queued texts for one file, only the newest is written.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "service/base/result.h"

namespace omni::daemon {

class FileWriter {
 public:
  // How long the end of the service waits for a disk; then unwritten texts are dropped, and the old files stay intact.
  static constexpr std::chrono::milliseconds kPatience{500};
  using Write = std::function<base::Status(const std::string& path, const std::string& text)>;

  explicit FileWriter(Write write);
  ~FileWriter();  // writes queued texts, within kPatience
  FileWriter(const FileWriter&) = delete;
  FileWriter& operator=(const FileWriter&) = delete;

  // Control thread only; neither waits for a disk. Numbers count from 1.
  std::uint64_t RequestWrite(const std::string& path, std::string text);
  struct Written {
    std::uint64_t number = 0;  // and of every earlier one for that file
    std::string path;
    base::Status status;
  };
  std::optional<Written> PopWritten();

 private:
  struct Shared;  // shared with the thread, which outlives this when a disk hangs
  const std::shared_ptr<Shared> shared_;
};

}  // namespace omni::daemon
