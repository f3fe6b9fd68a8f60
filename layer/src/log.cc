#include "layer/src/log.h"

#include <cstdlib>
#include <cstring>

#include "layer/src/clock.h"

namespace omni::layer {
namespace {
constexpr int kLinesPerPeriod = 50;
constexpr std::int64_t kPeriod_ns = 10'000'000'000;
}  // namespace

Log::Log() {
  const char* where = std::getenv("OMNI_LAYER_LOG");
  if (!where || !*where || std::strcmp(where, "0") == 0) return;
  file_ = std::strcmp(where, "1") == 0 ? stderr : std::fopen(where, "ae");
}

Log::~Log() {
  if (file_ && file_ != stderr) std::fclose(file_);
}

void Log::Line(const std::string& text) {
  if (!file_) return;
  const std::lock_guard lock(mutex_);
  const std::int64_t now = MonotonicNow_ns();
  if (now - period_start_ns_ > kPeriod_ns) {
    period_start_ns_ = now;
    lines_ = 0;
  }
  if (++lines_ > kLinesPerPeriod) {
    ++dropped_;
    return;
  }
  if (dropped_ > 0) std::fprintf(file_, "omni layer: %d lines dropped\n", dropped_);
  dropped_ = 0;
  std::fprintf(file_, "omni layer: %s\n", text.c_str());
  std::fflush(file_);
}

}  // namespace omni::layer
