// The hot kernel: model, residual and the sums of the normal equations at one pose, eight sensors side by side.
// No Eigen type crosses this interface: the body (kernel_body.h) is compiled for several vector widths, the widest that
// the processor has is chosen once. All widths add in the same order and fuse nothing, so they give the same bits.
#pragma once

#include <cstdint>
#include <type_traits>

namespace omni::tracker {

enum class Precision : std::uint8_t { kFloat, kDouble };  // of the sums; the steps are always double

inline constexpr int kBlockSensors = 8;
inline constexpr int kNuisancesMax = 6;  // of one scan: three currents, three components of an ambient field
inline constexpr int kParameters = 5;    // position x, y, z (m); turn of the axis along e1, e2 (rad)

// Where eight sensors are, and how the core answers there: the image of a sensor s at s' = (a/|s|)^2 s, n = s/|s|, and
// kappa (a/|s|)^3, kappa a/|s|^2. Without a core they are zero. docs/theory/tracking.md (2.1)
template <class Real>
struct alignas(64) SensorPlaces {
  Real position_base_m[3][kBlockSensors];
  Real image_base_m[3][kBlockSensors];
  Real radial_base[3][kBlockSensors];
  Real image_field_gain[kBlockSensors];
  Real image_potential_gain_1_m[kBlockSensors];
};

// Eight sensors of one scan, whitened: weight = diag(1/sigma) gain (zero row: that axis is not used), so that a
// residual is weight * B_model - whitened. Unused lanes repeat a sensor with zero weight.
template <class Real>
struct alignas(64) SensorBlock {
  Real weight[9][kBlockSensors];                    // 3 axis + component of B
  Real whitened[3][kBlockSensors];                  // by axis
  Real age_s[kBlockSensors];                        // the sample is so much older than the pose
  Real nuisance[3 * kNuisancesMax][kBlockSensors];  // 3 n + axis: whitened field of nuisance n at size 1
};

template <class Real>
struct ToolSource {
  Real zonal[3];          // q1, q3, q5, A m^(l+1)
  bool multipole = true;  // false: q3 = q5 = 0
  bool core = true;       // false: no iron responds
};

// Where to linearise. axis, tangent_1, tangent_2 are orthonormal; rates move the pose back to each sensor's instant.
struct KernelPose {
  double position_base_m[3];
  double axis_base[3];
  double tangent_1_base[3];
  double tangent_2_base[3];
  double rate_1_s[kParameters];
};

struct KernelTask {
  int parameters = kParameters;  // 3: the axis is held; 5
  int nuisances = 0;
  bool moment = false;  // also the column of a relative change of the tool's moment
};

// r: residuals, J: their derivatives, C: nuisances, M = weight * B_model: derivative by a relative change of the
// moment.
struct KernelSums {
  double JtJ[kParameters * (kParameters + 1) / 2];  // lower triangle, row by row
  double Jtr[kParameters];
  double rtr;
  double CtJ[kNuisancesMax][kParameters], Ctr[kNuisancesMax], CtM[kNuisancesMax];
  double MtJ[kParameters], MtM, Mtr;
};

// Whitened derivatives of eight sensors' readings: axis, parameter, sensor.
template <class Real>
struct alignas(64) JacobianBlock {
  Real J[3][kParameters][kBlockSensors];
};

// B in frame B at eight sensors and its derivative by the five parameters.
struct BlockField {
  double B_T[3][kBlockSensors];
  double derivative[kParameters][3][kBlockSensors];
};

inline constexpr int kGridLanes = 8;  // places of the search side by side

// What the search needs of one scan, reading by reading (3 i + axis). docs/theory/tracking.md (6.2)
struct ScoreTask {
  int readings = 0;
  int nuisances = 0;
  const float* inverse_sigma = nullptr;       // 0: not used
  const float* whitened = nullptr;            // already without the nuisances' best share: y - C S C^T y
  const float* nuisance[kNuisancesMax] = {};  // whitened columns
  float nuisance_covariance[kNuisancesMax * kNuisancesMax] = {};
};

// At kGridLanes places: how much of |y|^2 the best moment there explains, and that moment.
struct PlaceScores {
  float explained[kGridLanes];
  float moment_Am2[3][kGridLanes];
};

// In one precision. `places`, `blocks` and `jacobian` hold block_count entries.
template <class Real>
struct KernelIn {
  // Writes `jacobian` too, unless it is null.
  void (*sum)(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
              const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task,
              JacobianBlock<Real>* jacobian, KernelSums& sums) noexcept;
  // Residuals at another pose against the derivatives of a pose nearby, at a third of the cost: renews rtr, Jtr, Ctr,
  // and Mtr with the moment.
  void (*residual)(const SensorPlaces<Real>* places, const SensorBlock<Real>* blocks, int block_count,
                   const ToolSource<Real>& tool, const KernelPose& pose, const KernelTask& task,
                   const JacobianBlock<Real>* jacobian, KernelSums& sums) noexcept;
};

struct Kernel {
  const char* name;
  KernelIn<float> in_float;
  KernelIn<double> in_double;
  // field_sensor: (reading, moment axis, place), T / A m^2
  void (*score)(const float* field_sensor, const ScoreTask& task, PlaceScores& scores) noexcept;
  void (*field)(const SensorPlaces<double>& places, const ToolSource<double>& tool, const KernelPose& pose,
                BlockField& result) noexcept;
};

// The widest that this processor runs.
const Kernel& ActiveKernel() noexcept;

// All that this processor runs, narrowest first.
struct KernelList {
  const Kernel* kernels[2];
  int count;
};
KernelList RunnableKernels() noexcept;

template <class Real>
const KernelIn<Real>& KernelFor(const Kernel& kernel) noexcept {
  if constexpr (std::is_same_v<Real, float>) {
    return kernel.in_float;
  } else {
    return kernel.in_double;
  }
}

}  // namespace omni::tracker
