// The body of both kernels; each translation unit compiles it for its own instruction set.
#pragma once

#include <array>
#include <cstddef>

#include "service/base/lanes.h"
#include "service/sim/fields/charge_kernel.h"

namespace omni::sim {
namespace {

constexpr int kLanes = static_cast<int>(kChargeLanes);
using Lanes = base::Lanes<double, kLanes>;

inline void Load(const double* from, Lanes& lanes) noexcept { base::LoadLanes(from, lanes); }

inline void SquareRoot(const Lanes& a, Lanes& root) noexcept { base::SqrtLanes<double, kLanes>(a, root); }

inline double Total(const Lanes& a) noexcept { return (a[0] + a[1]) + (a[2] + a[3]); }

inline void SumOfCharges(const double* x, const double* y, const double* z, const double* q, std::size_t count,
                         const double point[3], double out[3]) noexcept {
  Lanes bx{};
  Lanes by{};
  Lanes bz{};
  for (std::size_t i = 0; i < count; i += 4) {
    Lanes dx;
    Lanes dy;
    Lanes dz;
    Lanes k;
    Load(x + i, dx);
    Load(y + i, dy);
    Load(z + i, dz);
    Load(q + i, k);
    dx = point[0] - dx;
    dy = point[1] - dy;
    dz = point[2] - dz;
    const Lanes d2 = dx * dx + dy * dy + dz * dz;
    Lanes d;
    SquareRoot(d2, d);
    k /= d2 * d;
    bx += k * dx;
    by += k * dy;
    bz += k * dz;
  }
  out[0] = Total(bx);
  out[1] = Total(by);
  out[2] = Total(bz);
}

// Recurrences of Legendre's polynomials and their derivatives [Abramowitz, Stegun 8.5.3, 8.5.4].
template <std::size_t kOrder>
constexpr auto Recurrence() noexcept {
  std::array<std::array<double, 2>, kOrder + 1> table{};
  for (std::size_t l = 0; l < table.size(); ++l) {
    table[l][0] = static_cast<double>(2 * l + 1) / static_cast<double>(l + 1);
    table[l][1] = static_cast<double>(l) / static_cast<double>(l + 1);
  }
  return table;
}

inline void FieldsOfZonal(const ZonalTerms& terms, const double* x, const double* y, const double* z, std::size_t count,
                          double* bx, double* by, double* bz) noexcept {
  static constexpr auto kRecurrence = Recurrence<kZonalOrder>();
  const double* axis = terms.axis.data();
  for (std::size_t i = 0; i < count; i += kChargeLanes) {
    Lanes rx;
    Lanes ry;
    Lanes rz;
    Load(x + i, rx);
    Load(y + i, ry);
    Load(z + i, rz);
    Lanes r;
    SquareRoot(rx * rx + ry * ry + rz * rz, r);
    const Lanes inverse_r = 1 / r;
    rx *= inverse_r;
    ry *= inverse_r;
    rz *= inverse_r;
    const Lanes c = axis[0] * rx + axis[1] * ry + axis[2] * rz;
    const Lanes ratio = terms.reference_m * inverse_r;
    const Lanes ratio2 = ratio * ratio;
    Lanes power = ratio * ratio2;   // (reference / r)^(l+2)
    Lanes p_before = {1, 1, 1, 1};  // P_{l-1}
    Lanes p = c;                    // P_l
    Lanes d_before{};               // P'_{l-1}
    Lanes d = {1, 1, 1, 1};         // P'_l
    Lanes along_r{};
    Lanes along_u{};
    for (std::size_t l = 1;; l += 2) {
      const Lanes weight = terms.scaled[l] * power;
      along_r += weight * static_cast<double>(l + 1) * p;
      along_u += weight * d;
      if (l + 2 > kZonalOrder) break;
      const Lanes p_even = kRecurrence[l][0] * c * p - kRecurrence[l][1] * p_before;
      const Lanes d_even = d_before + static_cast<double>(2 * l + 1) * p;
      const Lanes p_odd = kRecurrence[l + 1][0] * c * p_even - kRecurrence[l + 1][1] * p;
      d += static_cast<double>(2 * l + 3) * p_even;
      p_before = p_even;
      d_before = d_even;
      p = p_odd;
      power *= ratio2;
    }
    const Lanes radial = along_r + along_u * c;
    rx = radial * rx - along_u * axis[0];
    ry = radial * ry - along_u * axis[1];
    rz = radial * rz - along_u * axis[2];
    base::StoreLanes(rx, bx + i);
    base::StoreLanes(ry, by + i);
    base::StoreLanes(rz, bz + i);
  }
}

}  // namespace
}  // namespace omni::sim
