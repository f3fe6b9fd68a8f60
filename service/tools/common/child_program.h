// Programs of ours as children of a command, and a folder for what they leave.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

// A program beside this one (config::ProgramFolder). It gets SIGTERM at the end of this object, and when this process
// ends, however that happens.
class ChildProgram {
 public:
  // `log`: a new file for both outputs of a program in the background, which the terminal's Ctrl-C does not reach;
  // empty: it has this terminal. Error: it cannot be started.
  static base::Result<ChildProgram> Start(const std::string& name, const std::vector<std::string>& words,
                                          const std::string& log);
  ChildProgram(ChildProgram&& other) noexcept;
  ChildProgram& operator=(ChildProgram&& other) noexcept;
  ~ChildProgram();  // waits 3 s, then kills it

  // Its exit status, once it has ended; 128 + signal.
  std::optional<int> Poll();
  int Wait();

 private:
  explicit ChildProgram(pid_t pid) : pid_(pid) {}
  void End() noexcept;
  pid_t pid_ = -1;  // -1: moved from
  std::optional<int> status_;
};

// Of mode 0700, in the user's run-time folder, else in /tmp. Removed at the end, with everything in it.
class PrivateFolder {
 public:
  // `name`: "omni-try" -> .../omni-try-XXXXXX
  static base::Result<PrivateFolder> Make(const std::string& name);
  PrivateFolder(PrivateFolder&& other) noexcept;
  PrivateFolder& operator=(PrivateFolder&&) = delete;
  ~PrivateFolder();
  const std::string& path() const { return path_; }

 private:
  explicit PrivateFolder(std::string path) : path_(std::move(path)) {}
  std::string path_;  // empty: moved from
};

}  // namespace omni::tools
