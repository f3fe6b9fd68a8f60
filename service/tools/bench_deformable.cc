// omni bench deformable: its reference solvers are those of a program of its own.
#include "service/tools/bench_program.h"

namespace omni::tools {

base::Result<BenchRows> BenchDeformable(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_deformable", options);
}

}  // namespace omni::tools
