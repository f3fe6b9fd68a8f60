// Two lanes: SSE2, which every x86-64 has; other processors get what their compiler makes of it.
#define OMNI_FORCE_LANES 2
#define OMNI_FORCE_KERNEL ForceKernelBaseline
#include "service/actuation/force_kernel_lanes.h"
