// What every x86-64 has: SSE2.
#define OMNI_LANE_BYTES 16
#include "service/tracker/kernel/kernel_body.h"
#include "service/tracker/kernel/kernel_score.h"

namespace omni::tracker {

extern const Kernel kKernelBaseline;
const Kernel kKernelBaseline{
    "baseline", {SumAny<float>, ResidualAny<float>}, {SumAny<double>, ResidualAny<double>}, ScorePlaces, FieldOfBlock};

}  // namespace omni::tracker
