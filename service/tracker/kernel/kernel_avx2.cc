// Compiled for AVX2 without fused multiply-add.
#define OMNI_LANE_BYTES 32
#include "service/tracker/kernel/kernel_body.h"
#include "service/tracker/kernel/kernel_score.h"

namespace omni::tracker {

extern const Kernel kKernelAvx2;
const Kernel kKernelAvx2{
    "avx2", {SumAny<float>, ResidualAny<float>}, {SumAny<double>, ResidualAny<double>}, ScorePlaces, FieldOfBlock};

}  // namespace omni::tracker
