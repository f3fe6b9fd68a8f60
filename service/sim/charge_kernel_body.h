// The body of both kernels; each translation unit compiles it for its own instruction set.
#pragma once

#include <immintrin.h>

#include <cstddef>
#include <cstring>

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

}  // namespace
}  // namespace omni::sim
