// The twin's two sums that take most of its time, four at a time: over magnetic charges at one point, and over the
// orders of a zonal series at many. The same additions in the same order on every processor: with 256-bit registers
// where there are some, otherwise in halves.
#pragma once

#include <array>
#include <cstddef>

namespace omni::sim {

inline constexpr std::size_t kChargeLanes = 4;

// count: a multiple of kChargeLanes; no charge at the point. out: sum q d / |d|^3, d = point - charge.
using ChargeSum = void (*)(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                           const double point[3], double out[3]) noexcept;

// A coil's exterior field at 1 A, as ZonalSeries has it (winding.h).
// At contact the rest of the series is below 1e-5 of the force (tests/sim/fields.cc).
inline constexpr std::size_t kZonalOrder = 27;
struct ZonalTerms {
  std::array<double, kZonalOrder + 1> scaled{};  // 1e-7 q_l / reference^(l+2); odd orders count
  std::array<double, 3> axis{0, 0, 1};
  double reference_m = 0;
};

// count: a multiple of kChargeLanes; no point at the centre. bx, by, bz: T/A.
using ZonalFields = void (*)(const ZonalTerms& terms, const double* x, const double* y, const double* z,
                             std::size_t count, double* bx, double* by, double* bz) noexcept;

// The fastest that this processor has.
ChargeSum FastestChargeSum() noexcept;
ZonalFields FastestZonalFields() noexcept;

void ChargeSumBaseline(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                       const double point[3], double out[3]) noexcept;
void ChargeSumAvx2(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                   const double point[3], double out[3]) noexcept;
void ZonalFieldsBaseline(const ZonalTerms& terms, const double* x, const double* y, const double* z, std::size_t count,
                         double* bx, double* by, double* bz) noexcept;
void ZonalFieldsAvx2(const ZonalTerms& terms, const double* x, const double* y, const double* z, std::size_t count,
                     double* bx, double* by, double* bz) noexcept;

}  // namespace omni::sim
