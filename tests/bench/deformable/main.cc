// omni_bench_deformable [--seed N] [--quick]: rows as one JSON array on standard output. Run by `omni bench
// deformable`.
#include <cstring>
#include <iostream>

#include "tests/bench/deformable/rows.h"

int main(int argc, char** argv) {
  omni::bench::Settings settings;
  for (int k = 1; k < argc; ++k) {
    if (std::strcmp(argv[k], "--quick") == 0) {
      settings.quick = true;
    } else if (std::strcmp(argv[k], "--seed") == 0 && k + 1 < argc) {
      settings.seed = std::strtoull(argv[++k], nullptr, 10);
    } else {
      std::cerr << "usage: omni_bench_deformable [--seed N] [--quick]\n";
      return 2;
    }
  }
  omni::bench::Rows rows;
  omni::bench::AddTiming(settings, rows);
  omni::bench::AddAccuracy(settings, rows);
  omni::bench::AddPeers(settings, rows);
  omni::bench::AddLimits(settings, rows);
  omni::bench::AddReferenceTables(settings, rows);
  std::cout << nlohmann::ordered_json(rows).dump(1) << "\n";
  return 0;
}
