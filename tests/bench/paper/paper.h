// omni-bench paper: the figures of Langerak et al., Omni (UIST 2020), compared with the paper's method on the twin and
// with ours. Only numbers given in the paper's text are compared.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {

struct PaperOptions {
  std::uint64_t seed = 2101;  // of the first rig; the others follow
  int rigs = 40;
  int poses = 200;  // per rig and condition
};

// One part of the comparison.
struct PaperSection {
  std::string title;
  BenchRows rows;                  // those with a key "table" are what scripts/plot draws
  std::vector<std::string> notes;  // free parameters, seeds, interpretations of the text
};

PaperSection PaperTracking(const base::DeviceGeometry& device, const PaperOptions& options);  // Fig. 6
PaperSection PaperForces(const base::DeviceGeometry& device);                                 // Fig. 8
PaperSection PaperDecay(const base::DeviceGeometry& device);                                  // force against gap
PaperSection PaperHeat(const base::DeviceGeometry& device);                                   // Fig. 9
PaperSection PaperMagnets(const base::DeviceGeometry& device);                                // Fig. 5

}  // namespace omni::bench
