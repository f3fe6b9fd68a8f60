// Compiled with -mavx2 (CMakeLists.txt).
#include "service/sim/charge_kernel.h"
#include "service/sim/charge_kernel_body.h"

namespace omni::sim {

void ChargeSumAvx2(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                   const double point[3], double out[3]) noexcept {
  SumOfCharges(x, y, z, q, count, point, out);
}

}  // namespace omni::sim
