// omni_bench_deformable [--seed N] [--quick] [--part NAME]: rows as one JSON array on standard output; with --part only
// those of one part. Run by `omni-bench deformable`.
#include <algorithm>
#include <iostream>
#include <iterator>
#include <string>

#include "tests/bench/arguments.h"
#include "tests/bench/deformable/rows.h"
#include "tests/bench/printed_rows.h"

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
  std::string seed = std::to_string(settings.seed);
  const auto ended = omni::bench::ParseArguments(
      argc, argv, "omni_bench_deformable",
      {{"--quick", &settings.quick}, {"--seed", nullptr, &seed}, {"--part", nullptr, &only}});
  if (ended) return *ended;
  settings.seed = omni::bench::Number(seed);
  const auto named = [&only](const Part& part) { return only == part.name; };
  if (!only.empty() && std::none_of(std::begin(kParts), std::end(kParts), named)) {
    std::cerr << "omni_bench_deformable: --part: '" << only << "' is none of";
    for (const Part& part : kParts) std::cerr << " " << part.name;
    std::cerr << "\n";
    return 2;
  }
  omni::bench::Rows rows;
  for (const Part& part : kParts) {
    if (only.empty() || only == part.name) part.add(settings, rows);
  }
  omni::bench::PrintRows(rows);
  return 0;
}
