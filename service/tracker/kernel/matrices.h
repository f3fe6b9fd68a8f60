// The state's arrays as Eigen sees them. Products, sums and slices are Eigen's, of sizes known when they are compiled;
// inverses are SmallCholesky's (docs/decisions/0023).
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace omni::tracker {

template <int kRows, int kColumns = kRows>
using Matrix = Eigen::Matrix<double, kRows, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>;

// Row-major, square.
template <int kRows, std::size_t kCount>
Eigen::Map<Matrix<kRows>> AsMatrix(std::array<double, kCount>& values) noexcept {
  static_assert(kCount == std::size_t{kRows} * kRows);
  return Eigen::Map<Matrix<kRows>>(values.data());
}
template <int kRows, std::size_t kCount>
Eigen::Map<const Matrix<kRows>> AsMatrix(const std::array<double, kCount>& values) noexcept {
  static_assert(kCount == std::size_t{kRows} * kRows);
  return Eigen::Map<const Matrix<kRows>>(values.data());
}

template <std::size_t kCount>
Eigen::Map<Matrix<static_cast<int>(kCount), 1>> AsVector(std::array<double, kCount>& values) noexcept {
  return Eigen::Map<Matrix<static_cast<int>(kCount), 1>>(values.data());
}
template <std::size_t kCount>
Eigen::Map<const Matrix<static_cast<int>(kCount), 1>> AsVector(const std::array<double, kCount>& values) noexcept {
  return Eigen::Map<const Matrix<static_cast<int>(kCount), 1>>(values.data());
}

template <std::size_t kRows, std::size_t kColumns>
Eigen::Map<Matrix<static_cast<int>(kRows), static_cast<int>(kColumns)>> AsRows(
    std::array<std::array<double, kColumns>, kRows>& rows) noexcept {
  return Eigen::Map<Matrix<static_cast<int>(kRows), static_cast<int>(kColumns)>>(rows.front().data());
}
template <std::size_t kRows, std::size_t kColumns>
Eigen::Map<const Matrix<static_cast<int>(kRows), static_cast<int>(kColumns)>> AsRows(
    const std::array<std::array<double, kColumns>, kRows>& rows) noexcept {
  return Eigen::Map<const Matrix<static_cast<int>(kRows), static_cast<int>(kColumns)>>(rows.front().data());
}

}  // namespace omni::tracker
