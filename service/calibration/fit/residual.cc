#include "service/calibration/fit/residual.h"

#include "service/calibration/fit/tool_field.h"

namespace omni::calibration {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

ArrayState MakeArrayState(const Parameters& parameters, const base::Calibration& nominal, double remanence_A) {
  ArrayState array;
  array.unit = magnetics::MakeDiscMagnet(nominal.magnet, 1);
  array.kappa = parameters.Kappa();
  array.steel = parameters.Steel();
  array.centre.emplace_back(MirroredPlace(array.steel.height_base_m, Vector3d::Zero()), nominal.core_radius_m);
  for (int i = 0; i < parameters.sensors(); ++i) {
    array.sensors.push_back(parameters.Sensor(i));
    const Vector3d& place_m = array.sensors.back().position_base_m;
    array.fields.emplace_back(place_m, nominal.core_radius_m);
    array.mirrored.emplace_back(MirroredPlace(array.steel.height_base_m, place_m), nominal.core_radius_m);
    const auto& map = nominal.sensors[static_cast<std::size_t>(i)].current_map_T_A;
    array.remanence.push_back(remanence_A * Eigen::Map<const RowMajor3d>(map.data()));
  }
  return array;
}

namespace {

constexpr int kToolUnknowns = 6;  // pose (5), kappa

PlacedField<kToolUnknowns> WholeField(const FieldAtSensor& place, const ArrayState& array, const ToolFrame& frame) {
  const ToolField field = place.Evaluate(array.unit, array.kappa, frame);
  PlacedField<kToolUnknowns> whole;
  whole.B = field.direct + array.kappa * field.image;
  whole.by << field.by_pose, field.image;
  whole.by_place = field.by_sensor;
  return whole;
}

}  // namespace

Residual ComputeResidual(const Parameters& parameters, const ArrayState& array, std::size_t i, double tau,
                         const ToolFrame& frame, const Vector3d& remanence, const Eigen::Matrix<double, 3, 2>& kept,
                         const Vector3d& y) {
  const Tolerances& t = parameters.tolerances();
  const SensorState& sensor = array.sensors[i];
  const double m = parameters.Moment_Am2(tau);
  const double m_drawn = parameters.nominal().moment_Am2;
  const double core_radius_m = parameters.nominal().core_radius_m;
  PlacedField<kToolUnknowns> field = WholeField(array.fields[i], array, frame);
  SteelResponse<kToolUnknowns> steel =
      SteelResponseOf(sensor.position_base_m, core_radius_m, array.kappa, WholeField(array.mirrored[i], array, frame),
                      WholeField(array.centre.front(), array, frame));
  steel.field.by.col(5) += steel.of_core / array.kappa;
  field.B += array.steel.strength * steel.field.B;
  field.by += array.steel.strength * steel.field.by;
  field.by_place += array.steel.strength * steel.field.by_place;
  const Vector3d& shape = field.B;
  const Vector3d b = sensor.nominal * (m * shape + parameters.Ambient_T(tau));
  const Vector3d by_moment = m_drawn * (sensor.gain * shape);
  Residual out;
  out.r = sensor.error * b + array.remanence[i] * (remanence + kept * parameters.Kept()) - y;
  out.own.leftCols<5>() = m * sensor.gain * field.by.leftCols<5>();
  out.own.rightCols<3>() = array.remanence[i];
  out.array.middleCols<3>(kPositionAt) = (t.sensor_position_m * m) * sensor.gain * field.by_place;
  out.array.middleCols<9>(kGainAt) = parameters.GainJacobian(b);
  auto shared = out.array.rightCols<kSampleShared>();
  shared.col(kMomentAt) = t.moment * by_moment;
  shared.col(kMomentDriftAt) = (t.moment_drift * tau) * by_moment;
  shared.col(kMomentBowAt) = (kBowOfDrift * t.moment_drift * Bow(tau)) * by_moment;
  shared.col(kKappaAt) = (t.core_kappa * m) * (sensor.gain * field.by.col(5));
  shared.middleCols<3>(kAmbientAt) = t.ambient_T * sensor.gain;
  shared.middleCols<3>(kAmbientDriftAt) = (t.ambient_T * tau) * sensor.gain;
  shared.middleCols<kSteelAt - kHullAt>(kHullAt).setZero();
  shared.col(kSteelAt) = (parameters.SteelStrengthStep() * m) * (sensor.gain * steel.field.B);
  shared.col(kSteelDepthAt) =
      (parameters.SteelHeightStep_m() * array.steel.strength * m) * (sensor.gain * steel.by_height);
  shared.middleCols<2>(kKeptAt) = (t.core_kept_A / t.remanence_A) * (array.remanence[i] * kept);
  return out;
}

TouchResidual CompareTouch(const Parameters& parameters, const ToolFrame& frame) {
  const Tolerances& t = parameters.tolerances();
  ToolFrame from_hull = frame;
  from_hull.position_base_m += parameters.CoreCentre_m();
  const HullGap gap = GapToHull(parameters.nominal().magnet, parameters.HullRadius_m(), from_hull);
  TouchResidual out{gap.gap_m, gap.by_pose, Eigen::Matrix<double, 1, kSampleShared>::Zero()};
  out.by_shared[kHullAt] = -t.hull_radius_m;
  out.by_shared.middleCols<3>(kCentreAt) = t.core_centre_m * gap.by_pose.leftCols<3>();
  return out;
}

}  // namespace omni::calibration
