#include "tests/bench/layer/latency.h"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include "service/client/connection.h"

namespace omni::bench {
namespace {

// Further ahead than the layer predicts: the result depends on the newest sample alone.
constexpr XrDuration kAhead_ns = 100'000'000;
constexpr std::int64_t kPatience_ns = 30'000'000'000;

std::int64_t Monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

[[noreturn]] void Fail(const char* problem) {
  std::fprintf(stderr, "omni_bench_layer: %s\n", problem);
  std::exit(1);
}

}  // namespace

void PrintLatency(const App& app, int samples) {
  client::ConnectionInfo info;
  info.role = protocol::ClientRole::kMonitor;
  info.application = "omni_bench_layer";
  client::Connection connection(info);
  const std::int64_t start_ns = Monotonic_ns();
  while (!connection.connected()) {
    connection.Poll(Monotonic_ns());
    if (Monotonic_ns() - start_ns > kPatience_ns) Fail("no connection to omnid");
  }
  const auto reader = connection.state();
  std::vector<double> ms;
  XrPosef seen{};
  std::int64_t last_ns = 0;
  while (ms.size() < static_cast<std::size_t>(samples)) {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, nullptr, 0, {}};
    Check(xrLocateSpace(app.right, app.local, Now(app) + kAhead_ns, &location), "xrLocateSpace");
    const std::int64_t now_ns = Monotonic_ns();
    if (now_ns - start_ns > kPatience_ns) Fail("the pen's pose does not change");
    if (std::memcmp(&location.pose, &seen, sizeof(seen)) == 0) continue;
    const bool first = last_ns == 0;
    seen = location.pose;
    protocol::ToolSample sample;
    if (!reader->ReadNewest(sample) || sample.t_ns == last_ns) continue;
    last_ns = sample.t_ns;
    if (!first) ms.push_back(1e-6 * static_cast<double>(now_ns - sample.t_ns));
    if (ms.size() % 256 == 0) Sync(app);  // as an application does
  }
  std::sort(ms.begin(), ms.end());
  std::printf("{\"ms_p50\": %.4f, \"ms_p99\": %.4f, \"n\": %zu}\n", ms[ms.size() / 2], ms[ms.size() * 99 / 100],
              ms.size());
}

}  // namespace omni::bench
