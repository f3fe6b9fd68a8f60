#include "layer/src/instance/log.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "service/base/clock.h"
#include "service/protocol/text.h"

namespace omni::layer {
namespace {

constexpr int kLinesPerPeriod = 50;
constexpr std::int64_t kPeriod_ns = 10'000'000'000;

// O_NONBLOCK: to open a FIFO must not wait for its reader.
base::UniqueFd OpenLogFile(const std::string& path) {
  const int link = O_NOFOLLOW;
  const int flags = O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY | link;
  base::UniqueFd file(::open(path.c_str(), flags, S_IRUSR | S_IWUSR));
  struct stat info {};
  if (!file || ::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode)) return {};
  return file;
}

}  // namespace

Log::Log(const std::string& where) {
  if (where.empty() || where == "0") return;
  if (where != "1") file_ = OpenLogFile(where);
  fd_ = where == "1" ? STDERR_FILENO : file_.get();
}

void Log::WriteLine(const std::string& text) {
  if (fd_ < 0) return;
  const std::lock_guard lock(mutex_);
  const std::int64_t now = base::MonotonicNow_ns();
  if (now - period_start_ns_ > kPeriod_ns) {
    period_start_ns_ = now;
    lines_ = 0;
  }
  if (++lines_ > kLinesPerPeriod) {
    ++dropped_;
    return;
  }
  if (dropped_ > 0) Write(std::to_string(dropped_) + " lines dropped");
  dropped_ = 0;
  Write(protocol::Printable(text));
}

// In one piece, so that lines of several processes do not mix.
void Log::Write(const std::string& text) const {
  const std::string line = "omni layer: " + text + "\n";
  [[maybe_unused]] const auto written = ::write(fd_, line.data(), line.size());  // a full disk: nowhere to report it
}

}  // namespace omni::layer
