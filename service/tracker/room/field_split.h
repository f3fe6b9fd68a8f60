// Readings as a uniform field, known shapes, a field that changes evenly over the base, and the rest: what comes from
// far away, what the core keeps, what comes from not so far, and what each sensor has by itself.
// docs/theory/tracking.md (14.1), (14.2)
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

inline constexpr std::size_t kUniformShapes = 3, kGradientShapes = 5;

// A distant source's field at `r` is uniform and, to first order, B = T r with T symmetric and traceless: three
// uniform fields, then five gradients.
inline std::array<double, 3> FarFieldAt(std::size_t shape, double x, double y, double z) noexcept {
  switch (shape) {
    case 0:
      return {1, 0, 0};
    case 1:
      return {0, 1, 0};
    case 2:
      return {0, 0, 1};
    case 3:
      return {x, -y, 0};
    case 4:
      return {x, y, -2 * z};
    case 5:
      return {y, x, 0};
    case 6:
      return {z, 0, x};
    default:
      return {0, z, y};
  }
}

// Of kKnown shapes after the uniform ones. Readings that are not used are zero in each.
template <std::size_t kKnown>
struct FieldShapes {
  static constexpr std::size_t kFitted = kUniformShapes + kKnown, kCount = kFitted + kGradientShapes;
  std::array<ReadingLanes, kCount> rows;  // uniform, known, gradients
  int readings = kReadings;               // that are used

  // Of a sensor there whose reading is in frame B: the uniform ones and the gradients.
  void SetFar(std::size_t sensor, const base::Vec3& at_m) noexcept {
    for (std::size_t far = 0; far < kUniformShapes + kGradientShapes; ++far) {
      const std::array<double, 3> B = FarFieldAt(far, at_m.x, at_m.y, at_m.z);
      for (std::size_t axis = 0; axis < 3; ++axis) rows[OfFar(far)][kSensors * axis + sensor] = B[axis];
    }
  }
  static constexpr std::size_t OfFar(std::size_t far) noexcept { return far < kUniformShapes ? far : far + kKnown; }
};

template <std::size_t kKnown>
struct FieldSplit {
  std::array<double, FieldShapes<kKnown>::kFitted> sizes{};  // of the uniform and the known shapes
  ReadingLanes rest_T{};                                     // without these
  double rest_T2 = 0;                                        // mean square of the readings that are used
  double gradient_T2 = 0;                                    // of that, along the gradients
  double gradient = 0;                                       // the same per degree of freedom, over the remaining rest
};

// (U^T U + R)^-1 U^T y, R = diag(0, prior): what a reading's variance is over that of a known shape's size. False: they
// are not determined.
template <std::size_t kKnown>
bool FitShapes(const FieldShapes<kKnown>& shapes, double prior, const ReadingLanes& readings_T,
               std::array<double, FieldShapes<kKnown>::kFitted>& sizes) noexcept {
  constexpr std::size_t kFitted = FieldShapes<kKnown>::kFitted;
  std::array<double, kFitted * kFitted> H;
  for (std::size_t a = 0; a < kFitted; ++a) {
    for (std::size_t b = 0; b < kFitted; ++b) H[kFitted * a + b] = Dot(shapes.rows[a], shapes.rows[b]);
  }
  for (std::size_t a = kUniformShapes; a < kFitted; ++a) H[(kFitted + 1) * a] += prior;
  if (!InvertPositive<static_cast<int>(kFitted)>(H.data(), kFitted)) return false;
  sizes = {};
  double sum = 0;
  for (std::size_t b = 0; b < kFitted; ++b) {
    const double along = Dot(shapes.rows[b], readings_T);
    for (std::size_t a = 0; a < kFitted; ++a) sizes[a] += H[kFitted * a + b] * along;
    sum += along;
  }
  return std::isfinite(sum);
}

template <std::size_t kKnown>
void TakeOff(const FieldShapes<kKnown>& shapes, const std::array<double, FieldShapes<kKnown>::kFitted>& sizes,
             ReadingLanes& readings_T) noexcept {
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    for (std::size_t row = 0; row < readings_T.size(); ++row) readings_T[row] -= sizes[a] * shapes.rows[a][row];
  }
}

// Removes the part along `shape`.
inline void Remove(const ReadingLanes& shape, ReadingLanes& rows) noexcept {
  const double size = Dot(shape, rows) / Dot(shape, shape);
  for (std::size_t row = 0; row < rows.size(); ++row) rows[row] -= size * shape[row];
}

// False: not determined, or not finite.
template <std::size_t kKnown>
bool SplitField(FieldShapes<kKnown> shapes, const ReadingLanes& readings_T, FieldSplit<kKnown>& split) noexcept {
  using Shapes = FieldShapes<kKnown>;
  split.rest_T = readings_T;
  if (!FitShapes(shapes, 0, readings_T, split.sizes)) return false;
  TakeOff(shapes, split.sizes, split.rest_T);
  for (std::size_t a = 1; a < Shapes::kCount; ++a) {  // Gram-Schmidt
    for (std::size_t b = 0; b < a; ++b) Remove(shapes.rows[b], shapes.rows[a]);
  }
  const double all_T2 = Dot(split.rest_T, split.rest_T);
  ReadingLanes other_T = split.rest_T;
  for (std::size_t a = Shapes::kFitted; a < Shapes::kCount; ++a) Remove(shapes.rows[a], other_T);
  const double other_T2 = Dot(other_T, other_T);
  split.rest_T2 = all_T2 / shapes.readings;
  split.gradient_T2 = (all_T2 - other_T2) / shapes.readings;
  split.gradient =
      (all_T2 - other_T2) / kGradientShapes / (other_T2 / (shapes.readings - static_cast<int>(Shapes::kCount)));
  return std::isfinite(all_T2);
}

}  // namespace omni::tracker
