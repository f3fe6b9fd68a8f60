// omni_bench_layer: an ordinary OpenXR application that measures its own calls, with whatever layers the environment
// enables. `omni-bench layer` and `omni-bench ipc` run it.
//   --pen                 first wait until the right hand's pose is valid
//   --runtime LIBRARY     the runtime's, to count the calls that reach it
//   --count N             instead of times: N calls of each counted kind between markers (getppid), for a tracer
//   --memory              instead: what an instance and a session take
//   --latency N           instead: from a sensor's sample to its pose, N times
#include <cstdlib>
#include <string>

#include "tests/bench/arguments.h"
#include "tests/bench/layer/cost.h"
#include "tests/bench/layer/latency.h"

int main(int argc, char** argv) {
  using namespace omni::bench;
  bool pen = false;
  bool memory = false;
  std::string runtime, counted, latency;
  const auto ended = ParseArguments(argc, argv, "omni_bench_layer",
                                    {{"--pen", &pen},
                                     {"--memory", &memory},
                                     {"--count", nullptr, &counted},
                                     {"--latency", nullptr, &latency},
                                     {"--runtime", nullptr, &runtime}});
  if (ended) return *ended;
  const int count = std::atoi(counted.c_str()), samples = std::atoi(latency.c_str());
  if (memory) {
    PrintMemory(pen);
    return 0;
  }
  App app;
  CreateInstance(app);
  CreateSession(app);
  CreateActions(app);
  for (int i = 0; i < 10; ++i) Sync(app);
  if (pen) WaitForPen(app);
  if (samples > 0) {
    PrintLatency(app, samples);
  } else if (count > 0) {
    CountBetweenMarkers(app, count);
  } else {
    TimeCalls(app, runtime);
  }
  xrDestroyInstance(app.instance);
  return 0;
}
