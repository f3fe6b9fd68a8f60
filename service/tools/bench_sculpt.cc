// omni bench sculpt: done by a program of its own, which edits in one thread and reads in another.
#include "service/tools/bench_program.h"

namespace omni::tools {

base::Result<BenchRows> BenchSculpt(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_sculpt", options);
}

}  // namespace omni::tools
