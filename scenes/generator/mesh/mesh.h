// A triangle mesh while it is made: base frame, metres.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

namespace omni::scenes {

using Vec = glm::dvec3;
using Triangle = std::array<std::uint32_t, 3>;

struct Mesh {
  std::vector<Vec> positions;
  std::vector<Vec> colours;           // linear RGB in [0, 1]; empty: the material's
  std::vector<Triangle> triangles;    // counter-clockwise from outside
  std::vector<std::uint32_t> groups;  // of each triangle; empty: all 0. A group becomes a glTF primitive
};

// Positions are multiples of 2^-21 m (0.48 um): exact as floats, and free of the last bits in which mathematics
// libraries differ, so that the files are the same on every machine.
double Quantised(double value_m);

// Vertices of equal quantised position become one; triangles that collapse are dropped.
void Weld(Mesh& mesh);

// Appends `part`, its triangles in group `group`.
void Append(Mesh& mesh, const Mesh& part, std::uint32_t group);

// Unit normals, weighted by the angle of each triangle's corner.
std::vector<Vec> VertexNormals(const Mesh& mesh);

// Doubles vertices along edges where faces meet at more than `angle_deg`, so that they are drawn sharp. Positions stay.
Mesh SplitCreases(const Mesh& mesh, double angle_deg);

// Edges that do not have exactly two triangles which run along them in opposite directions. 0: closed and oriented.
std::size_t OpenEdges(const Mesh& mesh);

// Keeps the connected component with the most triangles.
void KeepLargestComponent(Mesh& mesh);

// 6 x the enclosed volume, positive when triangles are counter-clockwise from outside.
double SignedVolume6(const Mesh& mesh);

// Fewer triangles, same shape.

// Edge collapses in the order of their quadric error [Garland & Heckbert 1997] until `triangles` are left. `importance`
// (one per vertex, 1 = plain) multiplies the error: detail stays where it is high. A closed manifold stays one.
Mesh Decimate(const Mesh& mesh, const std::vector<double>& importance, std::size_t triangles);

}  // namespace omni::scenes
