#include "service/tools/calibrate/calibrate_zero.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

#include "service/base/eigen.h"

namespace omni::tools {
namespace {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr int kSettleScans = 300;  // at first: eddy currents in the core die out
constexpr int kBlockScans = 250;
constexpr int kFreshMin = calibration::kZeroBlocks * kBlockScans / 10;

}  // namespace

base::CoilCurrents ZeroSession::Add(const base::HallScan& scan) {
  const int at = scans_++ - kSettleScans;
  if (at < 0 || at >= calibration::kZeroBlocks * kBlockScans) return {};
  for (std::size_t i = 0; i < readings_.size(); ++i) {
    const Eigen::Map<const RowMajor3d> map(before_.sensors[i].current_map_T_A.data());
    const Vector3d read =
        base::ToEigen(scan.field_sensor_T[i]) - map * Eigen::Map<const Vector3d>(scan.coil_current_A.data());
    base::Vec3& sum = readings_[i][static_cast<std::size_t>(at / kBlockScans)];
    sum = base::FromEigen(base::ToEigen(sum) + read / kBlockScans);
    fresh_[i] += static_cast<int>((scan.fresh_mask >> i) & 1U);
    bad_ = bad_ || !read.allFinite() || ((scan.saturated_mask >> (3 * i)) & 7U) != 0;
  }
  return {};
}

bool ZeroSession::done() const { return scans_ >= kSettleScans + calibration::kZeroBlocks * kBlockScans; }

double ZeroSession::progress() const {
  return std::clamp(static_cast<double>(scans_) / (kSettleScans + calibration::kZeroBlocks * kBlockScans), 0.0, 1.0);
}

std::string ZeroSession::Instruction() const {
  return "Move the pen and other magnets a metre away, and do not touch the base for two seconds.";
}

base::Result<calibration::Zeroed> ZeroSession::Finish() const {
  const auto refused = [](const std::string& why) { return base::Error{"not zeroed: " + why}; };
  if (!done()) return refused("the readings ended before two seconds; start again");
  if (bad_) return refused("a sensor is saturated or has invalid readings: move the pen and other magnets away");
  const auto silent = std::find_if(fresh_.begin(), fresh_.end(), [](int fresh) { return fresh < kFreshMin; });
  if (silent != fresh_.end()) {
    return refused("sensor " + std::to_string(silent - fresh_.begin()) +
                   " sends nothing new: run omni device selftest");
  }
  return calibration::Rezero(before_, readings_);
}

}  // namespace omni::tools
