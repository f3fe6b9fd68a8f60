#include "service/tracker/kernel/steel.h"

#include "service/magnetics/disc_magnet.h"

namespace omni::tracker {
namespace {

constexpr double kFarPen_m = 0.09;

// Of the base's own field at the images of sensor i and of the core's centre, by component.
struct AtMirror {
  double sensor[3], centre[3];
};

// With M the mirror, B(s'), B(0') the base's own field at the images of sensor and core's centre, n = s / |s| and g the
// gain of the core's image at s:
//   B_steel(s) = strength (-M B(s') + g (3 (n.U) n - U)),   U = -M B(0')
std::array<double, 3> AnswerAt(const Model& model, std::size_t i, double scale, const AtMirror& field) noexcept {
  const double mirror[3] = {-scale, -scale, scale};
  const SensorPlaces<double>& places = model.places[0];
  double along = 0;
  for (std::size_t c = 0; c < 3; ++c) along += places.radial_base[c][i] * mirror[c] * field.centre[c];
  std::array<double, 3> answer{};
  for (std::size_t c = 0; c < 3; ++c) {
    const double of_core = 3 * along * places.radial_base[c][i] - mirror[c] * field.centre[c];
    answer[c] = mirror[c] * field.sensor[c] + places.image_field_gain[i] * of_core;
  }
  return answer;
}

void Set(LocalField& field, std::size_t i, const std::array<double, 3>& value) noexcept {
  for (std::size_t c = 0; c < 3; ++c) field[c][i] = value[c];
}

using Rows5 = Eigen::Matrix<double, kReadings, kParameters>;

// Whitened; `component(k, c, i)`: derivative of component c at sensor i with respect to parameter k.
template <class Component>
Rows5 Whitened(const Measurement& measurement, const Component& component) noexcept {
  Rows5 rows;
  for (std::size_t i = 0; i < kSensors; ++i) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t k = 0; k < kParameters; ++k) {
        double sum = 0;
        for (std::size_t c = 0; c < 3; ++c) sum += measurement.weight[3 * axis + c][i] * component(k, c, i);
        rows(static_cast<Eigen::Index>(kSensors * axis + i), static_cast<Eigen::Index>(k)) = sum;
      }
    }
  }
  return rows;
}

// B <- A^-1 B by elimination without pivoting: A is the pen's own normal matrix and what steel adds to it, which is
// less. False: it is more, and there is no answer.
bool SolveInPlace(Matrix5d A, Matrix5d& B) noexcept {
  for (int k = 0; k < kParameters; ++k) {
    if (!(A(k, k) > 0)) return false;
    for (int row = 0; row < kParameters; ++row) {
      if (row == k) continue;
      const double factor = A(row, k) / A(k, k);
      for (int column = k + 1; column < kParameters; ++column) A(row, column) -= factor * A(k, column);
      for (int column = 0; column < kParameters; ++column) B(row, column) -= factor * B(k, column);
    }
  }
  for (int k = 0; k < kParameters; ++k) B.row(k) /= A(k, k);
  return B.allFinite();
}

}  // namespace

SteelResponse SteelResponseOf(const Model& model, const Pose& pose, double moment_scale) noexcept {
  const SteelMirror& steel = model.steel;
  const double scale = steel.strength * moment_scale;
  const KernelPose at = ToKernel(MakePosePoint(pose), {}, {});
  BlockField mirrored, centre{};
  ActiveKernel().field(steel.sensors, model.tool, at, mirrored);
  if (model.tool.core) ActiveKernel().field(steel.centre, model.tool, at, centre);
  SteelResponse answer;
  for (std::size_t i = 0; i < kSensors; ++i) {
    const auto of = [&](const double(&sensor)[3][kBlockSensors], const double(&core)[3][kBlockSensors]) {
      return AnswerAt(model, i, scale,
                      {{sensor[0][i], sensor[1][i], sensor[2][i]}, {core[0][i], core[1][i], core[2][i]}});
    };
    Set(answer.field_T, i, of(mirrored.B_T, centre.B_T));
    for (std::size_t k = 0; k < kParameters; ++k) {
      Set(answer.derivative[k], i, of(mirrored.derivative[k], centre.derivative[k]));
    }
  }
  return answer;
}

bool SteelMatters(const Model& model) noexcept {
  if (!HasSteel(model)) return false;
  const Pose far{{0, 0, kFarPen_m}, -Eigen::Vector3d::UnitZ()};
  const LocalField steel_T = SteelResponseOf(model, far, 1).field_T;
  ModelField pen;
  EvaluateField(model, MakePosePoint(far), pen);
  double steel_T2 = 0, pen_T2 = 0;
  for (const auto& row : steel_T) {
    for (const double field_T : row) steel_T2 += field_T * field_T;
  }
  for (const double field_T : pen.field_sensor_T) pen_T2 += field_T * field_T;
  return !(steel_T2 <= kSteelShare * kSteelShare * pen_T2);
}

// With J, D the derivatives of the pen's field and of steel's answer, whitened, and x0 the pose `expected`: the fit x
// satisfies J (x - x*) = D (x* - x0), so that with G = (J^T J)^-1 J^T D
//   x* = x0 + (1 + G)^-1 (x - x0),   C* = (1 + G)^-1 C (1 + G)^-T                         docs/theory/tracking.md
//   (12.1) (1 + G)^-1 = (J^T J + J^T D)^-1 J^T J
void CorrectForSteel(const Model& model, const Measurement& measurement, const Pose& expected,
                     const SteelResponse& answer, Fit& fit) noexcept {
  BlockField tool;
  ActiveKernel().field(model.places[0], model.tool, ToKernel(MakePosePoint(expected), {}, {}), tool);
  const Rows5 J = Whitened(measurement, [&](std::size_t k, std::size_t c, std::size_t i) {
    return measurement.moment_scale * tool.derivative[k][c][i];
  });
  const Rows5 D =
      Whitened(measurement, [&](std::size_t k, std::size_t c, std::size_t i) { return answer.derivative[k][c][i]; });
  Matrix5d correct = J.transpose() * J;
  if (!SolveInPlace(correct + J.transpose() * D, correct)) return;
  const auto basis = magnetics::MakeTangentBasis(expected.axis_base);
  Eigen::Matrix<double, kParameters, 1> step;
  step.head<3>() = fit.pose.position_base_m - expected.position_base_m;
  step[3] = basis.e1.dot(fit.pose.axis_base);
  step[4] = basis.e2.dot(fit.pose.axis_base);
  step = correct * step;
  fit.pose.position_base_m = expected.position_base_m + step.head<3>();
  fit.pose.axis_base = (expected.axis_base + step[3] * basis.e1 + step[4] * basis.e2).normalized();
  fit.covariance = correct * fit.covariance * correct.transpose();
}

}  // namespace omni::tracker
