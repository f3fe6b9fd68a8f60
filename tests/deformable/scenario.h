// A small soft ball and a soft box, built once for all tests.
#pragma once

#include <gtest/gtest.h>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "service/haptics/deformable/soft_contact.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {

constexpr double kTip_m = 0.005;
constexpr double kSoftModulus_Pa = 2e5;

inline InputObject SoftBallMesh() {
  return CubeGrid(12, [](const Vec3& p) { return 0.03 * Normalized(p); });
}
inline InputObject SoftBoxMesh() {
  return CubeGrid(4, [](const Vec3& p) { return Vec3{0.025 * p.x, 0.02 * p.y, 0.015 * (p.z + 1)}; });
}

inline SoftBodyOptions SmallOptions() {
  SoftBodyOptions options;
  options.moduli = {kSoftModulus_Pa, 0.4, 1};
  options.lattice.max_tets = 500;
  return options;
}

inline base::Result<SoftBody> BuildSmall(const InputObject& mesh, const SoftBodyOptions& options) {
  SoftBuildReport report;
  return BuildSoftBody(mesh.vertices_base_m, mesh.triangles, options, report);
}

inline const SoftBody& SoftBall() {
  static const base::Result<SoftBody> body = BuildSmall(SoftBallMesh(), SmallOptions());
  return *body;
}

}  // namespace omni::haptics
