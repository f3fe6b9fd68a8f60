#include "service/tools/monitor/page_folder.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>

#include "service/config/paths.h"

namespace omni::tools {

base::Result<std::string> FindPage() {
  const std::string folder = config::DataFolder() + "/page";
  std::error_code error;
  if (std::filesystem::exists(folder + "/page.js", error)) return folder;
  return base::Error{"the page is not in " + folder +
                     ": Omni was built without npm; install npm (Debian: npm) and build again. `omni watch` shows the "
                     "pen in the terminal"};
}

bool OpenBrowser(const std::string& address) {
  const char* display = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  if ((display == nullptr || *display == 0) && (wayland == nullptr || *wayland == 0)) return false;
  std::string program = "xdg-open";
  std::string word = address;
  std::array<char*, 3> words{program.data(), word.data(), nullptr};
  posix_spawn_file_actions_t files;
  ::posix_spawn_file_actions_init(&files);
  for (const int fd : {STDOUT_FILENO, STDERR_FILENO}) {
    ::posix_spawn_file_actions_addopen(&files, fd, "/dev/null", O_WRONLY, 0);
  }
  pid_t pid = 0;
  const bool started = ::posix_spawnp(&pid, program.c_str(), &files, nullptr, words.data(), environ) == 0;
  ::posix_spawn_file_actions_destroy(&files);
  return started;
}

}  // namespace omni::tools
