// Four lanes; compiled with -mavx2.
#if defined(__AVX2__)
#define OMNI_LANE_BYTES 32
#define OMNI_FORCE_KERNEL ForceKernelAvx2
#include "service/actuation/force_kernel_lanes.h"
#endif
