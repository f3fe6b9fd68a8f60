// Four lanes; compiled with -mavx2.
#include "service/actuation/force_kernel.h"
#if defined(__AVX2__)
#define OMNI_FORCE_LANES 4
#define OMNI_FORCE_KERNEL ForceKernelAvx2
#include "service/actuation/force_kernel_lanes.h"
#endif
