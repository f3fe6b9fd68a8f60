// Eight lanes; compiled with -mavx512f.
#include "service/actuation/force_kernel.h"
#if defined(__AVX512F__)
#define OMNI_FORCE_LANES 8
#define OMNI_FORCE_KERNEL ForceKernelAvx512
#include "service/actuation/force_kernel_lanes.h"
#endif
