// L D L^T of a small symmetric matrix, without pivoting: for normal equations in the tick. Scaled to a unit diagonal
// first, since metres and radians differ by orders of magnitude.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace omni::tracker {

template <int kSize>
class SmallCholesky {
 public:
  using Vector = std::array<double, kSize>;

  // Factors A + damping diag(A), A row-major with `stride` to a row. False: not positive definite or not finite.
  bool Factor(const double* A, int stride, double damping) noexcept {
    bool usable = true;
    for (int i = 0; i < kSize; ++i) {
      const double diagonal = A[i * stride + i];
      usable &= diagonal > 0 && diagonal <= 1e300;
      scale_[i] = 1 / std::sqrt(diagonal);
    }
    if (!usable) return false;
    for (int j = 0; j < kSize; ++j) {
      double d = 1 + damping;
      for (int k = 0; k < j; ++k) d -= L_[j][k] * L_[j][k] * D_[k];
      if (!(d > 1e-13)) return false;
      D_[j] = d;
      inverse_[j] = 1 / d;
      for (int i = j + 1; i < kSize; ++i) {
        double sum = A[i * stride + j] * scale_[i] * scale_[j];
        for (int k = 0; k < j; ++k) sum -= L_[i][k] * L_[j][k] * D_[k];
        L_[i][j] = sum * inverse_[j];
      }
    }
    return true;
  }

  // A^-1 = S L^-T D^-1 L^-1 S, S: the scale of the diagonal. `inverse` is row-major, `stride` to a row.
  void Invert(double* inverse, int stride) const noexcept {
    double M[kSize][kSize];  // L^-1, unit lower triangle
    for (int j = 0; j < kSize; ++j) {
      for (int i = j + 1; i < kSize; ++i) {
        double sum = -L_[i][j];
        for (int k = j + 1; k < i; ++k) sum -= L_[i][k] * M[k][j];
        M[i][j] = sum;
      }
    }
    for (int i = 0; i < kSize; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = inverse_[i] * (i == j ? 1.0 : M[i][j]);
        for (int k = i + 1; k < kSize; ++k) sum += M[k][i] * inverse_[k] * M[k][j];
        inverse[stride * i + j] = inverse[stride * j + i] = sum * scale_[i] * scale_[j];
      }
    }
  }

  Vector Solve(const Vector& b) const noexcept {
    Vector x;
    for (int i = 0; i < kSize; ++i) {
      double sum = b[static_cast<std::size_t>(i)] * scale_[i];
      for (int k = 0; k < i; ++k) sum -= L_[i][k] * x[static_cast<std::size_t>(k)];
      x[static_cast<std::size_t>(i)] = sum;
    }
    for (int i = kSize - 1; i >= 0; --i) {
      double sum = x[static_cast<std::size_t>(i)] * inverse_[i];
      for (int k = i + 1; k < kSize; ++k) sum -= L_[k][i] * x[static_cast<std::size_t>(k)];
      x[static_cast<std::size_t>(i)] = sum;
    }
    for (int i = 0; i < kSize; ++i) x[static_cast<std::size_t>(i)] *= scale_[i];
    return x;
  }

  // Several right hand sides at once, b[row][side], in place.
  template <std::size_t kSides>
  void SolveSides(std::array<std::array<double, kSides>, kSize>& b) const noexcept {
    const auto add = [&b](std::size_t to, double factor, std::size_t from) {
      for (std::size_t c = 0; c < kSides; ++c) b[to][c] += factor * b[from][c];
    };
    const auto scale = [&b](std::size_t row, double factor) {
      for (double& x : b[row]) x *= factor;
    };
    for (std::size_t i = 0; i < kSize; ++i) {
      scale(i, scale_[i]);
      for (std::size_t k = 0; k < i; ++k) add(i, -L_[i][k], k);
    }
    for (std::size_t i = kSize; i-- > 0;) {
      scale(i, inverse_[i]);
      for (std::size_t k = i + 1; k < kSize; ++k) add(i, -L_[k][i], k);
    }
    for (std::size_t i = 0; i < kSize; ++i) scale(i, scale_[i]);
  }

 private:
  double L_[kSize][kSize], D_[kSize], inverse_[kSize], scale_[kSize];  // written by Factor
};

// In place, row-major, `stride` to a row. False: not positive definite, the matrix is as it was.
template <int kSize>
bool InvertPositive(double* matrix, int stride) noexcept {
  SmallCholesky<kSize> factors;
  if (!factors.Factor(matrix, stride, 0)) return false;
  factors.Invert(matrix, stride);
  return true;
}

}  // namespace omni::tracker
