// omni_bench_deformable [--seed N] [--quick] [--part NAME]: rows as one JSON array on standard output; of one part
// only, when it is named. Run by `omni bench deformable`.
#include <cstring>
#include <iostream>
#include <string>

#include "tests/bench/deformable/rows.h"

namespace {

struct Part {
  const char* name;
  void (*add)(const omni::bench::Settings&, omni::bench::Rows&);
};

// In this order: later ones fill in rows of earlier ones.
constexpr Part kParts[] = {{"timing", omni::bench::AddTiming},
                           {"accuracy", omni::bench::AddAccuracy},
                           {"peers", omni::bench::AddPeers},
                           {"limits", omni::bench::AddLimits},
                           {"references", omni::bench::AddReferenceTables}};

}  // namespace

int main(int argc, char** argv) {
  omni::bench::Settings settings;
  std::string only;
  for (int k = 1; k < argc; ++k) {
    if (std::strcmp(argv[k], "--quick") == 0) {
      settings.quick = true;
    } else if (std::strcmp(argv[k], "--seed") == 0 && k + 1 < argc) {
      settings.seed = std::strtoull(argv[++k], nullptr, 10);
    } else if (std::strcmp(argv[k], "--part") == 0 && k + 1 < argc) {
      only = argv[++k];
    } else {
      std::cerr
          << "usage: omni_bench_deformable [--seed N] [--quick] [--part timing|accuracy|peers|limits|references]\n";
      return 2;
    }
  }
  omni::bench::Rows rows;
  for (const Part& part : kParts) {
    if (only.empty() || only == part.name) part.add(settings, rows);
  }
  std::cout << nlohmann::ordered_json(rows).dump(1) << "\n";
  return 0;
}
