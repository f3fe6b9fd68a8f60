// omni bench surfaces: done by a program of its own, which builds the bodies that it shows.
#include "service/tools/bench_program.h"

namespace omni::tools {

base::Result<BenchRows> BenchSurfaces(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_surfaces", options);
}

}  // namespace omni::tools
