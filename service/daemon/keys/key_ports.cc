#include "service/daemon/keys/key_thread.h"

#include <fcntl.h>
#include <fnmatch.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace omni::daemon {
namespace {

namespace fs = std::filesystem;

constexpr const char* kNodes = "/dev/input/";
constexpr const char* kClass = "/sys/class/input/";

std::string Reason(int code) { return std::generic_category().message(code); }

class EvdevPorts : public KeyPorts {
 public:
  std::vector<std::string> FindDevices(const config::KeyDeviceRule& rule) override {
    if (!rule.path.empty()) return ByPath(rule.path);
    return ByName(rule.name_glob);
  }

  base::Result<int> Open(const std::string& path, bool grab) override {
    const int fd = ::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY);
    if (fd < 0) {
      const bool denied = errno == EACCES || errno == EPERM;
      return base::Error{path + ": cannot be opened (" + Reason(errno) + "); " +
                         (denied ? "a udev rule with TAG+=\"uaccess\" lets the user at the desk read it"
                                 : "check the path in inputs.toml")};
    }
    const std::string problem = Prepare(fd, grab);
    if (problem.empty()) return fd;
    ::close(fd);
    return base::Error{path + ": " + problem};
  }

  std::optional<std::vector<bool>> KeysDown(int fd, const std::vector<std::uint16_t>& codes) override {
    std::array<unsigned char, KEY_MAX / 8 + 1> bits{};
    if (::ioctl(fd, EVIOCGKEY(bits.size()), bits.data()) < 0) return std::nullopt;
    std::vector<bool> down;
    for (const std::uint16_t code : codes) down.push_back((bits.at(code / 8U) >> (code % 8U) & 1) != 0);
    return down;
  }

 private:
  static std::vector<std::string> ByPath(const std::string& path) {
    std::error_code error;
    const fs::path real = fs::canonical(path, error);  // links of by-id lead to one node
    return error ? std::vector<std::string>{} : std::vector<std::string>{real.string()};
  }

  static std::vector<std::string> ByName(const std::string& glob) {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::directory_iterator at(kClass, error), end; !error && at != end; at.increment(error)) {
      const std::string node = at->path().filename().string();
      if (node.compare(0, 5, "event") != 0) continue;
      std::ifstream file(at->path() / "device/name");
      std::string name;
      if (std::getline(file, name) && ::fnmatch(glob.c_str(), name.c_str(), 0) == 0) paths.push_back(kNodes + node);
    }
    std::sort(paths.begin(), paths.end());
    return paths;
  }

  // Empty: done.
  static std::string Prepare(int fd, bool grab) {
    int version = 0;
    if (::ioctl(fd, EVIOCGVERSION, &version) < 0) return "is not an input device; name one of /dev/input/";
    int clock = CLOCK_MONOTONIC;
    if (::ioctl(fd, EVIOCSCLOCKID, &clock) < 0)
      return "cannot use the monotonic clock for its time stamps (" + Reason(errno) + ")";
    if (grab && ::ioctl(fd, EVIOCGRAB, 1) < 0) {
      return "cannot be grabbed (" + Reason(errno) + "); end the program that has grabbed it, or write grab = false";
    }
    return {};
  }
};

}  // namespace

std::unique_ptr<KeyPorts> MakeEvdevPorts() { return std::make_unique<EvdevPorts>(); }

}  // namespace omni::daemon
