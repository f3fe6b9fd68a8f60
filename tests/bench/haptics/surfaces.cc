// omni-bench surfaces: runs a separate program, which builds the bodies that it displays.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchSurfaces(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_surfaces", options);
}

}  // namespace omni::bench
