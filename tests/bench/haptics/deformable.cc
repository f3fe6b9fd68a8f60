// omni-bench deformable: its reference solvers are those of a program of its own.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchDeformable(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_deformable", options);
}

}  // namespace omni::bench
