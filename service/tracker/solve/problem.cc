#include "service/tracker/solve/problem.h"

#include <type_traits>

namespace omni::tracker {
namespace {

template <class Real, class Source>
void Copy(const Source& source, std::size_t first, Real (&lanes)[kBlockSensors]) noexcept {
  for (std::size_t i = 0; i < kBlockSensors; ++i) lanes[i] = static_cast<Real>(source[first + i]);
}

// The moment's scale multiplies every order.
template <class Real>
void Scale(Real factor, ToolSource<Real>& tool) noexcept {
  if (factor == 1) return;
  for (Real& q : tool.zonal) q *= factor;
}

}  // namespace

template <class Real, int kCapacity>
void Pack(const Model& model, const BasicMeasurement<kCapacity>& measurement,
          Problem<Real, kCapacity>& problem) noexcept {
  if constexpr (std::is_same_v<Real, float>) {
    problem.tool = model.tool_float;
    problem.places = model.places_float.data();
  } else {
    problem.tool = model.tool;
    problem.places = model.places.data();
  }
  Scale(static_cast<Real>(measurement.moment_scale), problem.tool);
  problem.block_count = (measurement.sensors + kBlockSensors - 1) / kBlockSensors;
  for (int b = 0; b < problem.block_count; ++b) {
    SensorBlock<Real>& block = problem.blocks[b];
    const std::size_t first = static_cast<std::size_t>(b) * kBlockSensors;
    for (std::size_t row = 0; row < 3; ++row) {
      Copy(measurement.whitened[row], first, block.whitened[row]);
    }
    for (std::size_t row = 0; row < 9; ++row) Copy(measurement.weight[row], first, block.weight[row]);
    Copy(measurement.age_s, first, block.age_s);
    for (std::size_t row = 0; row < 3 * static_cast<std::size_t>(measurement.columns); ++row) {
      Copy(measurement.nuisance[row], first, block.nuisance[row]);
    }
  }
}

template void Pack(const Model&, const Measurement&, Problem<float, kSensors>&) noexcept;
template void Pack(const Model&, const Measurement&, Problem<double, kSensors>&) noexcept;
template void Pack(const Model&, const ArrayMeasurement&, Problem<float, kArraySensors>&) noexcept;
template void Pack(const Model&, const ArrayMeasurement&, Problem<double, kArraySensors>&) noexcept;

}  // namespace omni::tracker
