#include "service/tracker/kernel/kernel.h"

namespace omni::tracker {

extern const Kernel kKernelBaseline;
extern const Kernel kKernelAvx2;
extern const Kernel kKernelAvx512;

KernelList RunnableKernels() noexcept {
  KernelList list{{&kKernelBaseline}, 1};
  if (__builtin_cpu_supports("avx2")) list.kernels[list.count++] = &kKernelAvx2;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
      __builtin_cpu_supports("avx512dq")) {
    list.kernels[list.count++] = &kKernelAvx512;
  }
  return list;
}

const Kernel& ActiveKernel() noexcept {
  static const KernelList kList = RunnableKernels();
  return *kList.kernels[kList.count - 1];
}

}  // namespace omni::tracker
