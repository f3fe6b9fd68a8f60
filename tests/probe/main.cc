// omni_probe: records what a hand's controller does, through nothing but OpenXR, for the demo and for tests. An example
// to read is layer/examples/touch.

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "tests/probe/app.h"
#include "tests/probe/options.h"
#include "tests/probe/report.h"

namespace {

std::atomic<bool> stop{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

void OnSignal(int) { stop = true; }

constexpr int kFailed = 1;
constexpr int kUsageError = 2;
constexpr int kPenMissing = 3;

int Finish(const probe::Options& options, const probe::Report& report, bool started) {
  if (!options.json.empty() && !probe::WriteJson(options, report)) {
    std::fprintf(stderr, "omni_probe: --json %s: cannot be written: %s\n", options.json.c_str(), std::strerror(errno));
    return kFailed;
  }
  if (!started) return kFailed;
  const std::string missing = probe::MissingFromPen(report);
  if (options.expect_pen && !missing.empty()) {
    std::fprintf(stderr, "omni_probe: no pen in the %s hand: %s\n", options.hand.c_str(), missing.c_str());
    return kPenMissing;
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  probe::Options options;
  const auto asks_for_help = [](const char* word) { return std::strcmp(word, "--help") == 0; };
  if (std::any_of(argv + 1, argv + argc, asks_for_help)) {
    std::fputs(probe::kUsage, stdout);
    return 0;
  }
  if (const std::string error = probe::Parse(argc, argv, &options); !error.empty()) {
    std::fprintf(stderr, "omni_probe: %s\n%s", error.c_str(), probe::kUsage);
    return kUsageError;
  }
  std::signal(SIGINT, OnSignal);
  std::signal(SIGTERM, OnSignal);
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  probe::Report report;
  bool started = false;
  {
    probe::App app(options, &report);
    started = app.Start();
    if (started) app.Run(stop);
  }
  return Finish(options, report, started);
}
