// Two lanes: SSE2, which every x86-64 has; other processors get what their compiler makes of it.
#define OMNI_LANE_BYTES 16
#define OMNI_FORCE_KERNEL ForceKernelBaseline
#include "service/actuation/force_kernel_lanes.h"
