// What the tracker's kernel gets, for its tests and benchmarks.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdint>
#include <vector>

#include "service/tracker/kernel/kernel.h"
#include "tests/support/numeric.h"

namespace omni::support {

using tracker::kBlockSensors;

// Eight sensors each around a magnet at 0.05 m height; sizes and signs as in the base, otherwise random.
template <class Real>
struct KernelScene {
  std::vector<tracker::SensorPlaces<Real>> places;
  std::vector<tracker::SensorBlock<Real>> blocks;
  tracker::ToolSource<Real> tool{};
  tracker::KernelPose pose{};

  KernelScene(std::uint64_t seed, int block_count, bool core)
      : places(static_cast<std::size_t>(block_count)), blocks(static_cast<std::size_t>(block_count)) {
    Rng rng(seed);
    const auto real = [&rng](double low, double high) { return static_cast<Real>(Uniform(rng, low, high)); };
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      tracker::SensorBlock<Real>& block = blocks[b];
      for (int i = 0; i < kBlockSensors; ++i) {
        const Eigen::Vector3d s = Uniform(rng, 0.09, 0.13) * RandomUnit(rng);
        const double ratio = 0.015 / s.norm();
        places[b].image_field_gain[i] = static_cast<Real>(std::pow(ratio, 3));
        places[b].image_potential_gain_1_m[i] = static_cast<Real>(ratio / s.norm());
        for (int c = 0; c < 3; ++c) {
          places[b].position_base_m[c][i] = static_cast<Real>(s[c]);
          places[b].image_base_m[c][i] = static_cast<Real>(ratio * ratio * s[c]);
          places[b].radial_base[c][i] = static_cast<Real>(s[c] / s.norm());
          block.whitened[c][i] = real(-1000, 1000);
        }
        for (auto& row : block.weight) row[i] = real(-3e6, 3e6);
        for (auto& row : block.nuisance) row[i] = real(-300, 300);
        block.age_s[i] = real(0, 1e-3);
      }
    }
    tool.zonal[0] = 5;
    tool.zonal[1] = static_cast<Real>(-8e-4);
    tool.zonal[2] = static_cast<Real>(1e-7);
    tool.core = core;
    const Eigen::Vector3d u = RandomUnit(rng);
    const Eigen::Vector3d e1 = u.unitOrthogonal(), e2 = u.cross(e1);
    const double position[3] = {0.01, -0.02, 0.05};
    for (int c = 0; c < 3; ++c) {
      pose.position_base_m[c] = position[c];
      pose.axis_base[c] = u[c];
      pose.tangent_1_base[c] = e1[c];
      pose.tangent_2_base[c] = e2[c];
    }
    for (double& rate : pose.rate_1_s) rate = Uniform(rng, -1, 1);
  }
};

}  // namespace omni::support
