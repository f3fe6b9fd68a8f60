// omni-bench sculpt: done by a program of its own, which edits in one thread and reads in another.
#include "tests/bench/harness/program.h"

namespace omni::bench {

base::Result<BenchRows> BenchSculpt(const BenchOptions& options) {
  return RunBenchProgram("omni_bench_sculpt", options);
}

}  // namespace omni::bench
