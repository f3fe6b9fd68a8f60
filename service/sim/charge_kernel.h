// The sum over magnetic charges, four at a time. The same additions in the same order on every processor: with 256-bit
// registers where there are some, otherwise in halves.
#pragma once

#include <cstddef>

namespace omni::sim {

inline constexpr std::size_t kChargeLanes = 4;

// count: a multiple of kChargeLanes; no charge at the point. out: sum q d / |d|^3, d = point - charge.
using ChargeSum = void (*)(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                           const double point[3], double out[3]) noexcept;

// The fastest one that this processor has.
ChargeSum FastestChargeSum() noexcept;

void ChargeSumBaseline(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                       const double point[3], double out[3]) noexcept;
void ChargeSumAvx2(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                   const double point[3], double out[3]) noexcept;

}  // namespace omni::sim
