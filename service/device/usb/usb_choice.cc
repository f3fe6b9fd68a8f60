// Selects a base by serial, and finds who has it open, for messages.
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <utility>

#include "service/device/usb/usb_bus.h"

namespace omni::device {
namespace {

std::string Listed(const std::vector<UsbBase>& bases) {
  std::string text;
  for (const UsbBase& base : bases) {
    text +=
        (text.empty() ? "" : ", ") + (base.serial.empty() ? "one without a serial at port " + base.port : base.serial);
  }
  return text;
}

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

std::string UsbBaseName(const UsbBase& base) {
  return "usb base " + (base.serial.empty() ? "at port " + base.port : base.serial);
}

std::string UsbPermissionHelp(const std::string& node) {
  return "no permission for " + node +
         ": install manifests/udev/70-omni.rules as /etc/udev/rules.d/70-omni.rules, then run `sudo udevadm control "
         "--reload && sudo udevadm trigger --subsystem-match=usb` or plug the base in again";
}

base::Result<UsbBase> ChooseUsbBase(const std::vector<UsbBase>& bases, const std::string& serial) {
  if (bases.empty()) {
    return base::Error{"no Omni base on USB" + (serial.empty() ? std::string() : " (looked for " + serial + ")") +
                       ": connect it and switch its supply on; `omni device list` shows what is there"};
  }
  std::vector<UsbBase> matching;
  for (const UsbBase& base : bases) {
    if (serial.empty() || base.serial == serial) matching.push_back(base);
  }
  if (matching.size() == 1) return std::move(matching.front());
  if (matching.empty()) {
    return base::Error{"no Omni base with serial " + serial + " on USB; there is: " + Listed(bases)};
  }
  if (serial.empty()) {
    return base::Error{std::to_string(bases.size()) + " Omni bases on USB: " + Listed(bases) +
                       "; choose one: omnid --device usb:SERIAL, omni device ... SERIAL"};
  }
  return base::Error{std::to_string(matching.size()) + " Omni bases on USB have the serial " + serial +
                     "; disconnect all but one"};
}

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
