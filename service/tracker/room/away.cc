#include "service/tracker/room/away.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"
#include "service/tracker/room/field_split.h"

namespace omni::tracker {
namespace {

using Rows = ReadingLanes;
using Shapes = FieldShapes<base::kCoilCount>;  // known: what the core keeps

double Square(double x) noexcept { return x * x; }

Shapes ShapesOf(const Model& model) noexcept {
  Shapes shapes;
  const auto& at = model.places[0].position_base_m;
  for (std::size_t i = 0; i < kSensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t row = kSensors * axis + i;
      for (std::size_t k = 0; k < base::kCoilCount; ++k) {
        shapes.rows[kUniformShapes + k][row] = model.coil_map_T_A[(3 * i + axis) * base::kCoilCount + k];
      }
      for (std::size_t far = 0; far < kUniformShapes + kGradientShapes; ++far) {
        const std::array<double, 3> B = FarFieldAt(far, at[0][i], at[1][i], at[2][i]);
        double sum = 0;
        for (std::size_t c = 0; c < 3; ++c) sum += model.gain_sensor_base[3 * axis + c][i] * B[c];
        shapes.rows[Shapes::OfFar(far)][row] = sum;
      }
    }
  }
  return shapes;
}

// A mean of scans: the uniform field, what neither that nor the core makes, and how much of it a magnet afar could.
struct Found {
  std::array<double, 3> uniform_base_T{};
  Rows zeros_T{};       // the rest, with no more for the core than it ever keeps
  double rest_T2 = 0;   // mean square, whatever the core keeps
  double gradient = 0;  // of that: FieldSplit::gradient
};

bool Find(const Model& model, const Rows& mean_T, double core_T2_A2, Found& found) noexcept {
  const Shapes shapes = ShapesOf(model);
  std::array<double, Shapes::kFitted> sizes;
  found.zeros_T = mean_T;
  if (!FitShapes(shapes, core_T2_A2, mean_T, sizes)) return false;
  TakeOff(shapes, sizes, found.zeros_T);
  FieldSplit<base::kCoilCount> split;
  if (!SplitField(shapes, mean_T, split) || !std::isfinite(split.gradient)) return false;
  std::copy_n(split.sizes.begin(), kUniformShapes, found.uniform_base_T.begin());
  found.rest_T2 = split.rest_T2;
  found.gradient = split.gradient;
  return true;
}

// All 24 readings, without background and coils; false: one is unusable.
bool AddScan(const Model& model, const base::HallScan& scan, Rows& sum_T) noexcept {
  if (scan.saturated_mask != 0) return false;
  Rows next = sum_T;
  double total = 0;
  for (std::size_t i = 0; i < kSensors; ++i) {
    if (!base::IsFreshSample(scan, i)) return false;
    const base::Vec3& B = scan.field_sensor_T[i];
    const std::array<double, 3> field_T{B.x, B.y, B.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      double& sum = next[kSensors * axis + i];
      sum += field_T[axis] - model.background_sensor_T[axis][i];
      const double* row = &model.coil_map_T_A[(3 * i + axis) * base::kCoilCount];
      for (std::size_t k = 0; k < base::kCoilCount; ++k) sum -= row[k] * scan.coil_current_A[k];
      total += sum;
    }
  }
  if (!std::isfinite(total)) return false;
  sum_T = next;
  return true;
}

double SquareDistance(const std::array<double, 3>& a, const std::array<double, 3>& b) noexcept {
  return Square(a[0] - b[0]) + Square(a[1] - b[1]) + Square(a[2] - b[2]);
}

// P grows as a random walk to zero_T^2 in zero_s, never beyond.
void WidenZeros(const AwayOptions& options, std::int64_t t_ns, Away& away) noexcept {
  const double dt_s = std::clamp(base::Elapsed_s(t_ns, away.zero_ns), 0.0, options.zero_s);
  const double all_T2 = Square(options.zero_T);
  away.zero_variance_T2 = std::min(all_T2, away.zero_variance_T2 + all_T2 * dt_s / options.zero_s);
  away.zero_ns = t_ns;
}

// x <- x + k rest, k = P / (P + R), P <- (1 - k) P                                       docs/theory/tracking.md (14.3)
void LearnZeros(const AwayOptions& options, const Rows& rest_T, Away& away) noexcept {
  const double gain = away.zero_variance_T2 / (away.zero_variance_T2 + Square(options.window_error_T));
  for (std::size_t row = 0; row < rest_T.size(); ++row) away.zero_T[row] += gain * rest_T[row];
  away.zero_variance_T2 *= 1 - gain;
  away.learnt = true;
}

bool Conclude(const AwayOptions& options, const Found& found, DriftState& drift, Away& away) noexcept {
  const double moved_T2 = away.has_uniform ? SquareDistance(found.uniform_base_T, away.uniform_base_T) : 0;
  const bool steady = away.has_uniform && moved_T2 <= Square(options.steady_T);
  away.uniform_base_T = found.uniform_base_T;
  away.has_uniform = true;
  const bool quiet =
      found.gradient <= options.gradient_max && found.rest_T2 <= 4 * away.zero_variance_T2 + Square(options.quiet_T);
  if (quiet) {
    SetAmbient(found.uniform_base_T, Square(options.ambient_T) + moved_T2, drift);
  } else if (steady) {  // a magnet at rest, in what may be another field
    WidenAmbient(SquareDistance(found.uniform_base_T, AmbientField_T(drift)), drift);
  }
  if (!quiet || !steady) return false;
  LearnZeros(options, found.zeros_T, away);
  return true;
}

}  // namespace

void StartAway(const AwayOptions& options, std::int64_t t_ns, Away& away) noexcept {
  away = {};
  away.zero_ns = t_ns;
  away.zero_variance_T2 = Square(options.zero_T);
}

void SubtractZeros(const Away& away, base::HallScan& scan) noexcept {
  for (std::size_t i = 0; i < kSensors; ++i) {
    base::Vec3& B = scan.field_sensor_T[i];
    B = {B.x - away.zero_T[i], B.y - away.zero_T[kSensors + i], B.z - away.zero_T[2 * kSensors + i]};
  }
}

bool WatchAway(const AwayOptions& options, const Model& model, const base::HallScan& scan, DriftState& drift,
               Away& away) noexcept {
  if (away.scans == 0) {
    away.begun_ns = scan.t_ns;
    away.sum_T = {};
  }
  if (!AddScan(model, scan, away.sum_T)) {
    EndAwayWindow(away);
    return false;
  }
  ++away.scans;
  if (away.scans < options.window_scans || base::Elapsed_s(scan.t_ns, away.begun_ns) < options.window_s) return false;
  Rows mean_T = away.sum_T;
  for (double& value : mean_T) value /= away.scans;
  away.scans = 0;
  WidenZeros(options, scan.t_ns, away);
  Found found;
  const double core_T2_A2 = (away.zero_variance_T2 + Square(options.quiet_T)) / Square(options.core_A);
  return Find(model, mean_T, core_T2_A2, found) && Conclude(options, found, drift, away);
}

}  // namespace omni::tracker
