// A few lines about rare events, only where OMNI_LAYER_LOG asks for them: "1" for stderr, else a file to append to.
#pragma once

#include <cstdint>
#include <cstdio>
#include <mutex>
#include <string>

namespace omni::layer {

class Log {
 public:
  Log();
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  // At most kLinesPerPeriod in kPeriod_ns; what is dropped is counted in the next line.
  void Line(const std::string& text);

 private:
  std::FILE* file_ = nullptr;
  std::mutex mutex_;
  std::int64_t period_start_ns_ = 0;
  int lines_ = 0;
  int dropped_ = 0;
};

}  // namespace omni::layer
