// Model and measurement of one scan packed for the kernel, in either precision.
#pragma once

#include "service/tracker/kernel/kernel.h"
#include "service/tracker/kernel/measurement.h"
#include "service/tracker/kernel/model.h"

namespace omni::tracker {

// Where to linearise. axis, tangent_1, tangent_2 are orthonormal, right handed in the order (e1, e2, u).
struct PosePoint {
  std::array<double, 3> position_base_m{};
  std::array<double, 3> axis_base{};
  std::array<double, 3> tangent_1_base{};
  std::array<double, 3> tangent_2_base{};
};

template <class Real, int kCapacity>
struct Problem {
  const SensorPlaces<Real>* places = nullptr;  // of the model
  SensorBlock<Real> blocks[kCapacity / kBlockSensors];
  int block_count = 0;
  ToolSource<Real> tool;
};

template <class Real, int kCapacity>
void Pack(const Model& model, const BasicMeasurement<kCapacity>& measurement,
          Problem<Real, kCapacity>& problem) noexcept;

extern template void Pack(const Model&, const Measurement&, Problem<float, kSensors>&) noexcept;
extern template void Pack(const Model&, const Measurement&, Problem<double, kSensors>&) noexcept;
extern template void Pack(const Model&, const ArrayMeasurement&, Problem<float, kArraySensors>&) noexcept;
extern template void Pack(const Model&, const ArrayMeasurement&, Problem<double, kArraySensors>&) noexcept;

}  // namespace omni::tracker
