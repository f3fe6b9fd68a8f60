// Meshes of the collision bench: closed bodies by formula at any number of triangles, or a file's.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::collision {

using base::Vec3;
using namespace haptics;  // the operators of vec_math.h

struct Body {
  std::string name;
  bool smooth = false;         // direction errors mean something
  std::vector<Vec3> vertices;  // exact in float, so that engines in float have the same surface
  std::vector<std::array<std::uint32_t, 3>> triangles;

  // Filled by Connect: across the edge k -> k + 1, unit vertex normals weighted by angle.
  std::vector<std::array<std::uint32_t, 3>> neighbours;
  std::vector<Vec3> normals;
  bool closed = false;
};

// A lump of about 80 mm with waves on waves: every octave that `triangles` can carry with four edges a wave.
Body MakeLump(std::uint32_t triangles, std::uint64_t seed);

// A ring with trapezoid teeth and a stepped profile: flats, convex and concave edges, about 80 mm wide.
Body MakeGear(std::uint32_t triangles);

// Every triangle of a .glb file, meshes as they are (no node transforms), scaled to 80 mm, equal places welded.
base::Result<Body> ReadGlb(const std::string& path);
base::Result<haptics::InputObject> ReadGlbObject(const std::string& path);

void Connect(Body& body);

}  // namespace omni::collision
