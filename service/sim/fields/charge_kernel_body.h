// The body of both kernels; each translation unit compiles it for its own instruction set.
#pragma once

#include <immintrin.h>

#include <array>
#include <cstddef>
#include <cstring>

#include "service/sim/fields/charge_kernel.h"

namespace omni::sim {
namespace {

using Lanes = double __attribute__((vector_size(32)));

// Results by reference: returned by value they would have another calling convention without AVX.
inline void Load(const double* from, Lanes& lanes) noexcept { std::memcpy(&lanes, from, sizeof lanes); }

inline void SquareRoot(const Lanes& a, Lanes& root) noexcept {
#ifdef __AVX__
  const __m256d r = _mm256_sqrt_pd(_mm256_set_pd(a[3], a[2], a[1], a[0]));
  std::memcpy(&root, &r, sizeof root);
#else
  const __m128d low = _mm_sqrt_pd(_mm_set_pd(a[1], a[0]));
  const __m128d high = _mm_sqrt_pd(_mm_set_pd(a[3], a[2]));
  std::memcpy(&root, &low, sizeof low);
  std::memcpy(reinterpret_cast<char*>(&root) + sizeof low, &high, sizeof high);
#endif
}

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
    std::memcpy(bx + i, &rx, sizeof rx);
    std::memcpy(by + i, &ry, sizeof ry);
    std::memcpy(bz + i, &rz, sizeof rz);
  }
}

}  // namespace
}  // namespace omni::sim
