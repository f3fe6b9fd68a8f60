#define OMNI_LANE_BYTES 16
#include "service/sim/fields/charge_kernel.h"

#include "service/sim/fields/charge_kernel_body.h"

namespace omni::sim {

void ChargeSumBaseline(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                       const double point[3], double out[3]) noexcept {
  SumOfCharges(x, y, z, q, count, point, out);
}

void ZonalFieldsBaseline(const ZonalTerms& terms, const double* x, const double* y, const double* z, std::size_t count,
                         double* bx, double* by, double* bz) noexcept {
  FieldsOfZonal(terms, x, y, z, count, bx, by, bz);
}

ChargeSum FastestChargeSum() noexcept { return __builtin_cpu_supports("avx2") ? ChargeSumAvx2 : ChargeSumBaseline; }
ZonalFields FastestZonalFields() noexcept {
  return __builtin_cpu_supports("avx2") ? ZonalFieldsAvx2 : ZonalFieldsBaseline;
}

}  // namespace omni::sim
