// omni-bench sculpt: runs a separate program, which edits in one thread and reads in another.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchSculpt(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_sculpt", options);
}

}  // namespace omni::bench
