// The kernel's arithmetic, once for all widths and both precisions. docs/theory/tracking.md (2.1), (3.2), (4.2)
#pragma once

#include "service/tracker/kernel/kernel_fields.h"

namespace omni::tracker {
namespace {

constexpr int kTriangle = kParameters * (kParameters + 1) / 2;

// All sums of one group of lanes, in the order of KernelSums; nuisances and moment follow.
constexpr int kFirstJtr = kTriangle;
constexpr int kFirstRtr = kFirstJtr + kParameters;
constexpr int kFirstMoment = kFirstRtr + 1;                     // MtJ, MtM, Mtr
constexpr int kFirstNuisance = kFirstMoment + kParameters + 2;  // per nuisance CtJ, Ctr, CtM
constexpr int kPerNuisance = kParameters + 2;
constexpr int kSums = kFirstNuisance + kNuisancesMax * kPerNuisance;

// Whitened rows of one group: three axes.
template <class Real, int kCount>
struct Rows {
  Lane<Real> J[3][kCount];
  Lane<Real> r[3];
  Lane<Real> M[3];
};

// r = w B - age J rate - y: the residual at the pose moved back to the sample's instant.
template <class Real, int kCount>
inline Rows<Real, kCount> Whiten(const SensorBlock<Real>& block, int first, const LaneField<Real, kCount>& field,
                                 const Real (&rate)[kParameters]) {
  Rows<Real, kCount> rows;
  const Lane<Real> age = Load<Real>(block.age_s + first);
  for (int axis = 0; axis < 3; ++axis) {
    const Lane3<Real> w = Load3<Real>(block.weight + 3 * axis, first);
    rows.M[axis] = Dot(w, field.B);
    Lane<Real> drift{};
    for (int k = 0; k < kCount; ++k) {
      rows.J[axis][k] = Dot(w, field.d[k]);
      drift += rows.J[axis][k] * rate[k];
    }
    rows.r[axis] = rows.M[axis] - Load<Real>(block.whitened[axis] + first) - age * drift;
  }
  return rows;
}

template <class Real>
inline Lane<Real> Over3(const Lane<Real> (&a)[3], const Lane<Real> (&b)[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

template <class Real, int kCount>
inline void AddRows(const Rows<Real, kCount>& rows, const SensorBlock<Real>& block, int first, const KernelTask& task,
                    Lane<Real>* sums) {
  Lane<Real> J[kCount][3];  // by column
  for (int k = 0; k < kCount; ++k) {
    for (int axis = 0; axis < 3; ++axis) J[k][axis] = rows.J[axis][k];
  }
  for (int k = 0, e = 0; k < kCount; ++k) {
    for (int j = 0; j <= k; ++j, ++e) sums[e] += Over3<Real>(J[k], J[j]);
    sums[kFirstJtr + k] += Over3<Real>(J[k], rows.r);
  }
  sums[kFirstRtr] += Over3<Real>(rows.r, rows.r);
  if (task.moment) {
    for (int k = 0; k < kCount; ++k) sums[kFirstMoment + k] += Over3<Real>(J[k], rows.M);
    sums[kFirstMoment + kParameters] += Over3<Real>(rows.M, rows.M);
    sums[kFirstMoment + kParameters + 1] += Over3<Real>(rows.M, rows.r);
  }
  for (int n = 0; n < task.nuisances; ++n) {
    const Lane<Real> C[3] = {Load<Real>(block.nuisance[3 * n] + first), Load<Real>(block.nuisance[3 * n + 1] + first),
                             Load<Real>(block.nuisance[3 * n + 2] + first)};
    Lane<Real>* of = sums + kFirstNuisance + n * kPerNuisance;
    for (int k = 0; k < kCount; ++k) of[k] += Over3<Real>(J[k], C);
    of[kParameters] += Over3<Real>(C, rows.r);
    if (task.moment) of[kParameters + 1] += Over3<Real>(C, rows.M);
  }
}

template <class Real, int kCount>
inline void Reduce(const Lane<Real>* sums, const KernelTask& task, KernelSums& result) {
  const auto sum = [sums](int entry) { return SumBlock<Real>(sums + entry, kSums); };
  for (int k = 0, e = 0; k < kCount; ++k) {
    for (int j = 0; j <= k; ++j, ++e) result.JtJ[e] = sum(e);
    result.Jtr[k] = sum(kFirstJtr + k);
  }
  result.rtr = sum(kFirstRtr);
  if (task.moment) {
    for (int k = 0; k < kCount; ++k) result.MtJ[k] = sum(kFirstMoment + k);
    result.MtM = sum(kFirstMoment + kParameters);
    result.Mtr = sum(kFirstMoment + kParameters + 1);
  }
  for (int n = 0; n < task.nuisances; ++n) {
    const int of = kFirstNuisance + n * kPerNuisance;
    for (int k = 0; k < kCount; ++k) result.CtJ[n][k] = sum(of + k);
    result.Ctr[n] = sum(of + kParameters);
    if (task.moment) result.CtM[n] = sum(of + kParameters + 1);
  }
}

template <class Real, int kCount>
void SumBlocks(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
               const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task,
               JacobianBlock<Real>* jacobian, KernelSums& result) noexcept {
  const RealPose<Real> at = Narrow<Real>(pose);
  const LanePotential<Real, kCount> centre = CentrePotential<Real, kCount>(tool, at);
  Lane<Real> sums[kGroups<Real> * kSums];
  const int used = kFirstNuisance + task.nuisances * kPerNuisance;
  for (int group = 0; group < kGroups<Real>; ++group) {
    for (int e = 0; e < used; ++e) sums[group * kSums + e] = Lane<Real>{};
  }
  for (int b = 0; b < block_count; ++b) {
    for (int group = 0; group < kGroups<Real>; ++group) {
      const int first = group * kLanes<Real>;
      const LaneField<Real, kCount> field = FieldAt<Real, kCount>(tool, at, centre, places[b], first);
      const Rows<Real, kCount> rows = Whiten<Real, kCount>(blocks[b], first, field, at.rate);
      AddRows<Real, kCount>(rows, blocks[b], first, task, sums + group * kSums);
      if (jacobian == nullptr) continue;
      for (int axis = 0; axis < 3; ++axis) {
        for (int k = 0; k < kCount; ++k) Store<Real>(rows.J[axis][k], jacobian[b].J[axis][k] + first);
      }
    }
  }
  Reduce<Real, kCount>(sums, task, result);
}

template <class Real>
void SumAny(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
            const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task, JacobianBlock<Real>* jacobian,
            KernelSums& result) noexcept {
  if (task.parameters == 3) {
    SumBlocks<Real, 3>(places, blocks, block_count, tool, pose, task, jacobian, result);
  } else {
    SumBlocks<Real, kParameters>(places, blocks, block_count, tool, pose, task, jacobian, result);
  }
}

// One group's share of r^T r, M^T r, J^T r, C^T r, in this order.
template <class Real, int kCount>
inline void AddResidual(const SensorBlock<Real>& block, const JacobianBlock<Real>& jacobian, int first,
                        const Lane3<Real>& B, const Real (&rate)[kParameters], int nuisances, Lane<Real>* sums) {
  const Lane<Real> age = Load<Real>(block.age_s + first);
  for (int axis = 0; axis < 3; ++axis) {
    Lane<Real> J[kCount], drift{};
    for (int k = 0; k < kCount; ++k) {
      J[k] = Load<Real>(jacobian.J[axis][k] + first);
      drift += J[k] * rate[k];
    }
    const Lane<Real> M = Dot(Load3<Real>(block.weight + 3 * axis, first), B);
    const Lane<Real> r = M - Load<Real>(block.whitened[axis] + first) - age * drift;
    sums[0] += r * r;
    sums[1] += M * r;
    for (int k = 0; k < kCount; ++k) sums[2 + k] += J[k] * r;
    for (int n = 0; n < nuisances; ++n) {
      sums[2 + kCount + n] += Load<Real>(block.nuisance[3 * n + axis] + first) * r;
    }
  }
}

template <class Real, int kCount>
void ResidualBlocks(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
                    const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task,
                    const JacobianBlock<Real>* jacobian, KernelSums& result) noexcept {
  constexpr int kStride = 2 + kCount + kNuisancesMax;
  const RealPose<Real> at = Narrow<Real>(pose);
  const Lane<Real> centre = PotentialOf(LookFromCentre(tool, at));
  Lane<Real> sums[kGroups<Real> * kStride] = {};
  for (int b = 0; b < block_count; ++b) {
    for (int group = 0; group < kGroups<Real>; ++group) {
      const int first = group * kLanes<Real>;
      const Lane3<Real> B = FieldOnlyAt<Real>(tool, at, centre, places[b], first);
      AddResidual<Real, kCount>(blocks[b], jacobian[b], first, B, at.rate, task.nuisances, sums + group * kStride);
    }
  }
  result.rtr = SumBlock<Real>(sums, kStride);
  if (task.moment) result.Mtr = SumBlock<Real>(sums + 1, kStride);
  for (int k = 0; k < kCount; ++k) result.Jtr[k] = SumBlock<Real>(sums + 2 + k, kStride);
  for (int n = 0; n < task.nuisances; ++n) result.Ctr[n] = SumBlock<Real>(sums + 2 + kCount + n, kStride);
}

template <class Real>
void ResidualAny(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
                 const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task,
                 const JacobianBlock<Real>* jacobian, KernelSums& result) noexcept {
  if (task.parameters == 3) {
    ResidualBlocks<Real, 3>(places, blocks, block_count, tool, pose, task, jacobian, result);
  } else {
    ResidualBlocks<Real, kParameters>(places, blocks, block_count, tool, pose, task, jacobian, result);
  }
}

void FieldOfBlock(const SensorPlaces<double>& places, const ToolSource<double>& tool, const KernelPose& pose,
                  BlockField& result) noexcept {
  const RealPose<double> at = Narrow<double>(pose);
  const LanePotential<double, kParameters> centre = CentrePotential<double, kParameters>(tool, at);
  for (int group = 0; group < kGroups<double>; ++group) {
    const int first = group * kLanes<double>;
    const LaneField<double, kParameters> field = FieldAt<double, kParameters>(tool, at, centre, places, first);
    const auto store = [first](const Lane3<double>& B, double(*rows)[kBlockSensors]) {
      Store<double>(B.x, rows[0] + first);
      Store<double>(B.y, rows[1] + first);
      Store<double>(B.z, rows[2] + first);
    };
    store(field.B, result.B_T);
    for (int k = 0; k < kParameters; ++k) store(field.d[k], result.derivative[k]);
  }
}

}  // namespace
}  // namespace omni::tracker
