// The search's arithmetic: lanes are places, not sensors. Internal to each kernel file, like kernel_lanes.h.
#pragma once

#include "service/tracker/kernel/kernel_lanes.h"

namespace omni::tracker {
namespace {

using FloatLane = Lane<float>;

// Lower triangle of N = G^T W^2 G, b = G^T W^2 y and the nuisances' C^T W G.
struct PlaceSums {
  FloatLane N[6], b[3], CtG[kNuisancesMax][3];
};

inline PlaceSums SumReadings(const float* field_sensor, const ScoreTask& task, int first) {
  PlaceSums sums{};
  for (int r = 0; r < task.readings; ++r) {
    const float w = task.inverse_sigma[r];
    if (w == 0) continue;
    const float* at = field_sensor + 3 * kGridLanes * r + first;
    const FloatLane g[3] = {w * Load(at), w * Load(at + kGridLanes), w * Load(at + 2 * kGridLanes)};
    for (int i = 0, e = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j, ++e) sums.N[e] += g[i] * g[j];
      sums.b[i] += g[i] * task.whitened[r];
    }
    for (int n = 0; n < task.nuisances; ++n) {
      for (int i = 0; i < 3; ++i) sums.CtG[n][i] += task.nuisance[n][r] * g[i];
    }
  }
  return sums;
}

// N - (C^T G)^T S C^T G
inline void EliminateNuisances(const ScoreTask& task, PlaceSums& sums) {
  for (int a = 0; a < task.nuisances; ++a) {
    FloatLane S_CtG[3]{};
    for (int b = 0; b < task.nuisances; ++b) {
      for (int i = 0; i < 3; ++i) S_CtG[i] += task.nuisance_covariance[a * kNuisancesMax + b] * sums.CtG[b][i];
    }
    for (int i = 0, e = 0; i < 3; ++i) {
      for (int j = 0; j <= i; ++j, ++e) sums.N[e] -= sums.CtG[a][i] * S_CtG[j];
    }
  }
}

// Variable projection [Golub & Pereyra 1973]: at a fixed place the model is linear in the moment, y = G m; explained =
// b^T N^-1 b. N is scaled to a trace of one before its determinant is formed.
void ScorePlaces(const float* field_sensor, const ScoreTask& task, PlaceScores& scores) noexcept {
  for (int first = 0; first < kGridLanes; first += kLanes<float>) {
    PlaceSums sums = SumReadings(field_sensor, task, first);
    EliminateNuisances(task, sums);
    const FloatLane scale = 1.0f / (sums.N[0] + sums.N[2] + sums.N[5]);
    const FloatLane xx = sums.N[0] * scale, yx = sums.N[1] * scale, yy = sums.N[2] * scale, zx = sums.N[3] * scale,
                    zy = sums.N[4] * scale, zz = sums.N[5] * scale;
    const FloatLane c_xx = yy * zz - zy * zy, c_yx = zy * zx - yx * zz, c_zx = yx * zy - yy * zx;
    const FloatLane c_yy = xx * zz - zx * zx, c_zy = yx * zx - xx * zy, c_zz = xx * yy - yx * yx;
    const FloatLane over = scale / (xx * c_xx + yx * c_yx + zx * c_zx);
    const FloatLane(&b)[3] = sums.b;
    const FloatLane m[3] = {over * (c_xx * b[0] + c_yx * b[1] + c_zx * b[2]),
                            over * (c_yx * b[0] + c_yy * b[1] + c_zy * b[2]),
                            over * (c_zx * b[0] + c_zy * b[1] + c_zz * b[2])};
    Store<float>(b[0] * m[0] + b[1] * m[1] + b[2] * m[2], scores.explained + first);
    for (int i = 0; i < 3; ++i) Store<float>(m[i], scores.moment_Am2[i] + first);
  }
}

}  // namespace
}  // namespace omni::tracker
