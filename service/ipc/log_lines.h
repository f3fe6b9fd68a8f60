// Log lines with a limit, against floods by a misbehaving client: a line that was just written is not written again.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

namespace omni::ipc {

class LogLines {
 public:
  explicit LogLines(std::function<void(const std::string&)> sink);  // empty: standard error
  void Write(const std::string& line, std::int64_t now_ns);

 private:
  std::function<void(const std::string&)> sink_;
  std::string last_line_;
  std::int64_t last_ns_ = 0;
  std::int64_t window_start_ns_ = 0;
  int lines_in_window_ = 0;
};

}  // namespace omni::ipc
