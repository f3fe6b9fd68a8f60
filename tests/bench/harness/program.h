// Benches that are separate programs in the folder of this one: their peers' licences and reference solvers stay out of
// omni.
#pragma once

#include <string>

#include "tests/bench/harness/bench.h"

namespace omni::bench {

// Path of the program `name` in the folder of this one. Error: not built.
base::Result<std::string> ProgramBeside(const std::string& name);

// Rows that the program `name` prints: one JSON array of flat rows (tests/bench/printed_rows.h). It is given --seed,
// --quick, --ticks and --mesh of `options`. Error: not built, failed, or printed something else.
base::Result<BenchRows> RunBenchProgram(const std::string& name, const BenchOptions& options);

}  // namespace omni::bench
