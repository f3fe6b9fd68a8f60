// omni-bench surfaces: done by a program of its own, which builds the bodies that it shows.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchSurfaces(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_surfaces", options);
}

}  // namespace omni::bench
