// omni_touch: see what a hand's controller does, through nothing but OpenXR. It works with any runtime that offers
// XR_MND_headless, and is written to be copied.

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "layer/examples/touch/app.h"
#include "layer/examples/touch/options.h"
#include "layer/examples/touch/report.h"

namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void OnSignal(int) { stop = true; }

constexpr int kFailed = 1;
constexpr int kUsageError = 2;
constexpr int kPenMissing = 3;

int Finish(const touch::Options& options, const touch::Report& report, bool started) {
  if (!options.json.empty() && !touch::WriteJson(options, report)) {
    std::fprintf(stderr, "omni_touch: --json %s: cannot be written: %s\n", options.json.c_str(), std::strerror(errno));
    return kFailed;
  }
  if (!started) return kFailed;
  const std::string missing = touch::MissingFromPen(report);
  if (options.expect_pen && !missing.empty()) {
    std::fprintf(stderr, "omni_touch: no pen in the %s hand: %s\n", options.hand.c_str(), missing.c_str());
    return kPenMissing;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  touch::Options options;
  if (argc == 2 && std::strcmp(argv[1], "--help") == 0) {
    std::fputs(touch::kUsage, stdout);
    return 0;
  }
  if (const std::string error = touch::Parse(argc, argv, &options); !error.empty()) {
    std::fprintf(stderr, "omni_touch: %s\n%s", error.c_str(), touch::kUsage);
    return kUsageError;
  }
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  touch::Report report;
  bool started = false;
  {
    touch::App app(options, &report);
    started = app.Start();
    if (started) app.Run(stop);
  }
  return Finish(options, report, started);
}
