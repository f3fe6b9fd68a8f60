// omni-bench deformable: runs a separate program, which has the reference solvers.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchDeformable(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_deformable", options);
}

}  // namespace omni::bench
