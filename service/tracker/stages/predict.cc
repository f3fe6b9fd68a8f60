#include "service/tracker/stages/predict.h"

#include <algorithm>
#include <cmath>

#include "service/base/clock.h"
#include "service/base/eigen.h"
#include "service/magnetics/dipole.h"
#include "service/tracker/stages/scan_context.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

void LearnFromLast(const Config& config, RoomState& room) noexcept {
  if (!room.evidence.valid) return;
  const std::array<double, 3> ambient_T = AmbientField_T(room.drift);
  const AmbientEvidence said = CorrectDrift(config.drift, room.evidence, room.drift);
  room.evidence.valid = false;
  if (IsToBeIdentified(room.magnet)) IdentifyMagnet(config.magnets, room.drift, room.magnet);
  if (said.valid && config.mains.enabled) LearnMains(config.mains, said, ambient_T, room.evidence.age_s, room.mains);
}

PenPlace PlaceOf(const Model& model, double moment_scale, const FilterState& filter) noexcept {
  const auto& variance_m2 = filter.covariance_pp;
  const Vector3d moment_Am2 = moment_scale * model.moment_Am2 * base::ToEigen(filter.axis_base);
  using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Vector3d core_A = Eigen::Map<const RowMajor3d>(model.core_current_A_T.data()) *
                          magnetics::DipoleField(moment_Am2, base::ToEigen(filter.position_base_m));
  return {filter.position_base_m, filter.axis_base, base::FromEigen(core_A),
          std::sqrt(variance_m2[0] + variance_m2[4] + variance_m2[8]), std::sqrt(2 * filter.variance_angle)};
}

// Every few scans all drifting quantities are unknowns.
bool IsWideScan(const Config& config, const State& state) noexcept {
  const RoomState& room = state.room;
  return LearnsDrift(config) &&
         (room.scans % static_cast<std::uint32_t>(std::max(1, config.drift.every_scans)) == 0 ||
          IsAmbientLively(config.drift, room.drift) || (state.pose.warm && !room.magnet.identified));
}

void PredictRoom(const Config& config, const base::HallScan& scan, State& state, Predicted& predicted) noexcept {
  RoomState& room = state.room;
  LearnFromLast(config, room);
  AdvanceMains(config.mains, scan.t_ns, room.mains);
  predicted.mains = FieldOfMains(room.mains);
  const PenPlace place = PlaceOf(config.model, MomentScale(room.drift), state.pose.filter);
  const PenPlace* const pen = state.pose.warm ? &place : nullptr;
  if (LearnsDrift(config) && ArePlausible(scan.coil_current_A)) {
    FollowCore(config.drift, scan.coil_current_A, pen, room.drift);
  }
  predicted.wide = IsWideScan(config, state);
  if (predicted.wide) PredictDrift(config.drift, scan.t_ns, pen, room.drift);
}

}  // namespace

Predicted PredictTo(const Config& config, const Received& received, bool pushed, State& state) noexcept {
  const PoseState& pose = state.pose;
  Predicted predicted(pose.filter);
  PredictRoom(config, received.scan(), state, predicted);
  predicted.dt_s = base::Elapsed_s(received.scan().t_ns, pose.filter_t_ns);
  predicted.continues = pose.warm && predicted.dt_s >= 0 && predicted.dt_s <= config.coast_max_s;
  if (predicted.continues) PredictFilter(config.filter, predicted.dt_s, pushed, predicted.filter);
  if (pose.warm && HasSteel(config.model)) {
    predicted.steel = SteelResponseOf(config.model, PoseOf(predicted.filter), MomentScale(state.room.drift));
  }
  return predicted;
}

}  // namespace omni::tracker
