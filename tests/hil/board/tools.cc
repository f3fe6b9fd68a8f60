#include "tests/hil/board/tools.h"

#include <unistd.h>

#include <cstdlib>
#include <sstream>

namespace omni::hil {

std::string ImagePath(const std::string& name) { return std::string(OMNI_IMAGE_DIR) + "/" + name + ".elf"; }

std::string FindProgram(const std::string& name) {
  const char* path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  std::string folder;
  while (std::getline(folders, folder, ':')) {
    std::string program = folder + "/" + name;
    if (!folder.empty() && ::access(program.c_str(), X_OK) == 0) return program;
  }
  return {};
}

std::string NoBoardReason() {
  if (std::string(OMNI_IMAGE_DIR).empty())
    return "built without firmware images: run scripts/setup all and build again";
  if (FindProgram("qemu-system-arm").empty()) return "there is no qemu-system-arm: run scripts/setup all";
  return {};
}

}  // namespace omni::hil
