// Benches that are programs of their own, beside this one: their peers' licences and reference solvers stay out of
// omni.
#pragma once

#include <string>

#include "tests/bench/harness/bench.h"

namespace omni::bench {

// Rows that the program `name` prints: one JSON array of flat rows (tests/bench/printed_rows.h). It is given --seed,
// --quick, --ticks and --mesh as they were asked for. Error: not built, failed, or printed something else.
base::Result<BenchRows> RunBenchProgram(const std::string& name, const BenchOptions& options);

}  // namespace omni::bench
