#include "service/device/usb/usb_holders.h"

#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>

namespace omni::device {
namespace {

namespace fs = std::filesystem;

// The process of a folder of /proc; 0: not a process.
int PidOf(const std::string& name) {
  const bool digits = !name.empty() && name.size() < 10 &&
                      std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  return digits ? std::stoi(name) : 0;
}

bool HasOpen(const fs::path& process, const std::string& node) {
  std::error_code error;  // a process that ends meanwhile, or of another user
  for (fs::directory_iterator fd(process / "fd", error), end; !error && fd != end; fd.increment(error)) {
    std::error_code gone;
    if (fs::read_symlink(fd->path(), gone) == node && !gone) return true;
  }
  return false;
}

}  // namespace

std::vector<Holder> HoldersOf(const std::string& node, const std::string& proc) {
  std::vector<Holder> holders;
  std::error_code error;
  for (fs::directory_iterator entry(proc, error), end; !error && entry != end; entry.increment(error)) {
    const int pid = PidOf(entry->path().filename().string());
    if (pid == 0 || pid == getpid() || !HasOpen(entry->path(), node)) continue;
    Holder holder{.pid = pid, .name = "?"};
    std::ifstream comm(entry->path() / "comm");
    std::getline(comm, holder.name);
    holders.push_back(holder);
  }
  std::sort(holders.begin(), holders.end(), [](const Holder& a, const Holder& b) { return a.pid < b.pid; });
  return holders;
}

std::string HoldersText(const std::vector<Holder>& holders) {
  std::string text;
  for (const Holder& holder : holders) {
    text += (text.empty() ? "" : ", ") + holder.name + " (pid " + std::to_string(holder.pid) + ")";
  }
  return text;
}

}  // namespace omni::device
