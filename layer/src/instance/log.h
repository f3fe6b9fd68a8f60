// A few lines about rare events, only if OMNI_LAYER_LOG enables them: "1" for stderr, else a file to append to.
// The text is made printable: names from applications and runtimes end up in it.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "service/base/unique_fd.h"
#include "service/protocol/environment.h"

namespace omni::layer {

class Log {
 public:
  // A new file is private to this user. Only regular files are written to, no link, FIFO or device.
  explicit Log(const std::string& where = protocol::EnvironmentVariable("OMNI_LAYER_LOG"));
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  // At most kLinesPerPeriod in kPeriod_ns; what is dropped is counted in the next line.
  void WriteLine(const std::string& text);

 private:
  void Write(const std::string& text) const;

  base::UniqueFd file_;
  int fd_ = -1;  // < 0: nothing is written
  std::mutex mutex_;
  std::int64_t period_start_ns_ = 0;
  int lines_ = 0;
  int dropped_ = 0;
};

}  // namespace omni::layer
