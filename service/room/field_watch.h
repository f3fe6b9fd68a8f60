// Whether the field around the base is still the one of its calibration: from samples of the loop, second by second,
// with a pen (from what the tracker has learnt) and without (from the readings themselves).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/eigen.h"
#include "service/base/limits.h"
#include "service/room/room_finding.h"
#include "service/room/verdict.h"
#include "service/tracker/room_sample.h"
#include "service/tracker/solve/static_solve.h"

namespace omni::room {

class FieldWatch {
 public:
  static constexpr double kUniform_T = 15e-6;  // more than a field drifts in an hour; a base that is turned sees more
  static constexpr double kSteady_T = 10e-6;   // below it again: unchanged
  static constexpr double kUneven_T = 3e-6;    // more than what the zeros of sensors drift
  static constexpr double kEven = 0.15;        // of the uniform part: a distant source adds no more unevenness
  static constexpr double kWanders_T = 1e-6;   // rms of a second: a magnet at rest does not respond to a pen

  explicit FieldWatch(const base::Calibration& calibration);

  void Add(const tracker::RoomSample& sample);
  // useless: bit i: ignore sensor i. contradicted: a magnet is near, and neither a pose nor what is known of the
  // sensors explains the readings.
  void EndSecond(std::uint32_t useless, bool contradicted);
  void Report(std::vector<RoomFinding>& findings) const;
  // Of the last second in which it was found: the uniform field about the base, base frame. Empty: a magnet is near, or
  // nothing was judged in that second.
  const std::optional<Eigen::Vector3d>& field_T() const noexcept { return field_T_; }
  bool magnet_near() const noexcept { return is_magnet_.holds(); }

 private:
  using Fields = Eigen::Matrix<double, 3, base::kSensorCount>;
  struct Second {
    int samples = 0, tracked = 0, stray = 0, quiet = 0;
    Eigen::Vector3d ambient_sum_T = Eigen::Vector3d::Zero();
    double ambient_square_T2 = 0;
    Fields reading_sum_T = Fields::Zero();  // of quiet samples
    Eigen::Vector3d current_sum_A = Eigen::Vector3d::Zero();
  };
  void JudgeTracked();
  void JudgeResting(std::uint32_t useless);
  bool IsPen(const Fields& reading_T, const Eigen::Vector3d& current_A, std::uint32_t useless) const;

  base::Calibration calibration_;
  std::optional<tracker::StaticSolver> solver_;
  Second second_;
  bool has_fitted_ = false;                                 // poses have explained the readings of a whole second
  Eigen::Vector3d calibrated_T_ = Eigen::Vector3d::Zero();  // uniform part of the calibration's background
  std::optional<Eigen::Vector3d> field_T_;
  double uniform_T_ = 0;                                              // of the last second in which it was found
  Verdict is_magnet_{3}, wanders_{5}, is_uniform_{3}, is_uneven_{3};  // an approaching magnet wanders too
};

}  // namespace omni::room
