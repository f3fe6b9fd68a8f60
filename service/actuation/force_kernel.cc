#include "service/actuation/force_kernel.h"

namespace omni::actuation {

ForceKernel ForceKernelOf(ForceKernelLevel level) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  switch (level) {
    case ForceKernelLevel::kAvx2:
      return __builtin_cpu_supports("avx2") ? ForceKernelAvx2 : nullptr;
    case ForceKernelLevel::kBaseline:
      break;
  }
  return ForceKernelBaseline;
#else
  return level == ForceKernelLevel::kBaseline ? ForceKernelBaseline : nullptr;
#endif
}

ForceKernel BestForceKernel() noexcept {
  for (int level = kForceKernelLevels - 1; level > 0; --level) {
    const ForceKernel kernel = ForceKernelOf(static_cast<ForceKernelLevel>(level));
    if (kernel != nullptr) return kernel;
  }
  return ForceKernelBaseline;
}

}  // namespace omni::actuation
