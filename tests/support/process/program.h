// Our programs as a person runs them: with their arguments, exit status, and output; optionally on a terminal of a
// given width.
#pragma once

#include <fcntl.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "service/base/clock.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {

struct Ran {
  int status = -1;  // 128 + signal when killed, as it is after the patience
  std::string out, err;
};

using Words = std::vector<std::string>;

inline std::string BinaryPath(const std::string& program) { return OMNI_BINARY_DIR "/bin/" + program; }

// After fork. `environment`: "NAME=value".
[[noreturn]] inline void ExecuteProgram(const Words& words, const Words& environment) {
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    ::setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
  }
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(const_cast<char*>(word.c_str()));
  argv.push_back(nullptr);
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

inline int WaitForProgram(pid_t pid, double patience_s) {
  const std::int64_t end_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(patience_s * 1e9);
  int status = 0;
  while (::waitpid(pid, &status, WNOHANG) == 0) {
    if (base::MonotonicNow_ns() > end_ns) ::kill(pid, SIGKILL);
    ::usleep(2000);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// words[0]: the program's path. Its output goes into files.
inline Ran RunProgram(const Words& words, const Words& environment = {}, double patience_s = 60) {
  const TempFolder folder;
  const std::string out = folder.Path("out"), err = folder.Path("err");
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::dup2(::open(out.c_str(), O_WRONLY | O_CREAT, 0600), STDOUT_FILENO);
    ::dup2(::open(err.c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO);
    ::unsetenv("COLUMNS");
    ExecuteProgram(words, environment);
  }
  Ran ran{.status = WaitForProgram(pid, patience_s)};
  const auto text = [](const std::string& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  ran.out = text(out);
  ran.err = text(err);
  return ran;
}

// On its own terminal; `out` is the text on it.
inline Ran RunOnTerminal(const Words& words, int columns, const Words& environment = {}) {
  winsize size{.ws_row = 50, .ws_col = static_cast<unsigned short>(columns), .ws_xpixel = 0, .ws_ypixel = 0};
  int terminal = -1;
  const pid_t pid = ::forkpty(&terminal, nullptr, nullptr, &size);
  if (pid == 0) {
    ::unsetenv("COLUMNS");
    ExecuteProgram(words, environment);
  }
  Ran ran;
  char bytes[4096];
  for (ssize_t n = 0; (n = ::read(terminal, bytes, sizeof(bytes))) > 0;)
    ran.out.append(bytes, static_cast<std::size_t>(n));
  ::close(terminal);
  ran.status = WaitForProgram(pid, 60);
  std::erase(ran.out, '\r');
  return ran;
}

}  // namespace omni::test
