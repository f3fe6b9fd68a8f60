// Compiled for AVX-512 (F, VL, DQ): doubles eight at a time.
#define OMNI_KERNEL_BYTES 64
#include "service/tracker/kernel/kernel_body.h"
#include "service/tracker/kernel/kernel_score.h"

namespace omni::tracker {

extern const Kernel kKernelAvx512;
const Kernel kKernelAvx512{
    "avx512", {SumAny<float>, ResidualAny<float>}, {SumAny<double>, ResidualAny<double>}, ScorePlaces, FieldOfBlock};

}  // namespace omni::tracker
