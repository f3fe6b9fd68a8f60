#include "service/tracker/kernel/kernel.h"

namespace omni::tracker {

extern const Kernel kKernelBaseline;
extern const Kernel kKernelAvx2;

KernelList RunnableKernels() noexcept {
  KernelList list{{&kKernelBaseline}, 1};
  if (__builtin_cpu_supports("avx2")) list.kernels[list.count++] = &kKernelAvx2;
  return list;
}

const Kernel& ActiveKernel() noexcept {
  static const KernelList kList = RunnableKernels();
  return *kList.kernels[kList.count - 1];
}

}  // namespace omni::tracker
