// Extruding: press a face until it clicks, then pull it out or push it in by whole steps. docs/theory/haptics.md,
// section 9.
#pragma once

#include <span>
#include <vector>

#include "service/base/work_watch.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/geometry/surface.h"
#include "service/haptics/scene/material.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

// The tip's contact with one region in this tick; force 0: not touched.
struct RegionTouch {
  double normal_force_N = 0;
  double depth_m = 0;
};

struct ExtrudeInput {
  bool tracked = false;
  Vec3 tip;
  Vec3 velocity_m_s;
  double dt_s = 0;
  double stiffness_limit_N_m = 0;  // what stability allows
};

// Advances one region and returns the force it adds on the tool: the click, and the face sticking to the pen when
// pulled.
Vec3 StepRegion(const Region& region, const Extrude& extrude, const RegionTouch& touch, const ExtrudeInput& input,
                RegionState& state) noexcept;

// The faces of an object that can be pushed and pulled (find_faces.cc): connected triangles of one extrudable material
// that face roughly the same way. Set-up only.
struct Face {
  std::vector<std::uint32_t> triangles;
  Vec3 normal;  // area-weighted mean, unit
  Vec3 centroid_base_m;
  double area_m2 = 0;
  double radius_m = 0;
  std::uint32_t material = 0;
};

// Largest first. A material that wraps around an edge gives one face per side: a triangle joins if its normal is within
// about 35 degrees of the largest triangle's. Slivers under 5 % of the largest face stay rigid.
std::vector<Face> FindFaces(const Mesh& mesh, const std::vector<Material>& materials,
                            const base::WorkWatch& watch = {});

}  // namespace omni::haptics
