// Third-party solvers on the tracker's own problem, so that a benchmark compares solvers and not problems: the same
// readings, the same whitening, the same model (docs/theory/tracking.md (2.1)) unless stated otherwise. Every peer is
// built once and then solves scan after scan on one thread. Not for the tick: they allocate.
#pragma once

#include <array>
#include <memory>

#include "service/base/device_geometry.h"
#include "service/base/vec.h"
#include "service/tracker/kernel/linearise.h"

namespace omni::peers {

inline constexpr int kPeerReadings = tracker::kReadings;
inline constexpr int kPeerNuisances = tracker::kNuisancesMax;

// One static scan as residuals: r = D F(pose) - y with D = diag(1/sigma), then r - U (U^T r): disturbances of all
// sensors in a known shape are eliminated. docs/theory/tracking.md (3.2)
struct PeerScan {
  std::array<double, kPeerReadings> inverse_sigma{};                    // 1/T; 0: not used
  std::array<double, kPeerReadings> whitened{};                         // y = D (the tool's share of the reading)
  std::array<double, kPeerReadings * kPeerNuisances> nuisance_basis{};  // U, row-major
  std::size_t nuisances = 0;                                            // columns of U in use
};
PeerScan MakePeerScan(const tracker::Measurement& measurement);

struct PeerPose {
  base::Vec3 position_base_m;
  base::Vec3 axis_base{0, 0, -1};  // unit
};

struct PeerFit {
  PeerPose pose;
  double chi2 = 0;
  int iterations = 0;
  bool converged = false;
};

// A step that changes chi2 by less than this ends the tracker's own solver; peers stop by the same rule. Errors then
// stay within 1 % of those at the exact minimum (checks/solvers.cc).
inline constexpr double kPeerChi2Done = 1e-3;

struct PeerOptions {
  // Relative change of the cost; chi2 of a fit is about its degrees of freedom.
  double function_tolerance = kPeerChi2Done / (kPeerReadings - tracker::kParameters);
  int iterations_max = 50;
};

class Peer {
 public:
  Peer() = default;
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  virtual ~Peer() = default;
  virtual PeerFit Solve(const PeerScan& scan, const PeerPose& start) = 0;
};

enum class PeerLinearSolver { kDenseQr, kNormalCholesky };

// Ceres with the tracker's analytic Jacobian. Position in R3, axis on the sphere (SphereManifold).
std::unique_ptr<Peer> MakeCeresAnalytic(const tracker::Model& model, PeerLinearSolver linear,
                                        const PeerOptions& options);
// Ceres with dual numbers through the same model written again for any scalar (any_scalar_model.h).
std::unique_ptr<Peer> MakeCeresAutodiff(const base::Calibration& calibration, PeerLinearSolver linear,
                                        const PeerOptions& options);
// ceres::TinySolver with the analytic Jacobian: fixed size, no allocation; the axis in a chart around the start,
// because it does not support manifolds.
std::unique_ptr<Peer> MakeCeresTiny(const tracker::Model& model, const PeerOptions& options);

}  // namespace omni::peers
