// A rounded block of clay that lies on the dome: wherever it is pressed and held, it can be pulled out and pushed in.
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scenes/generator/models/scene_models.h"

namespace omni::scenes {
namespace {

constexpr double kLength_m = 0.040, kWidth_m = 0.030, kHeight_m = 0.018;
constexpr double kTop_m = 0.045;   // 7.5 mm above the hull, where the base is strong
constexpr double kDome_m = 0.038;  // the underside is cut to the hull, and lies just over it
constexpr double kFillet_m = 0.003;
constexpr int kFilletSteps = 3;

enum Face : std::uint32_t { kBody, kTop, kRight, kFront };

// Coordinates along one edge of the sharp box: fillet, flat, fillet.
std::vector<double> Ticks(double half_m, int flat_steps) {
  std::vector<double> ticks;
  ticks.reserve(static_cast<std::size_t>(flat_steps) + 2 * kFilletSteps + 1);
  for (int i = 0; i < kFilletSteps; ++i) ticks.push_back(-half_m + kFillet_m * i / kFilletSteps);
  for (int i = 0; i <= flat_steps; ++i) ticks.push_back((half_m - kFillet_m) * (2.0 * i / flat_steps - 1));
  for (int i = kFilletSteps - 1; i >= 0; --i) ticks.push_back(half_m - kFillet_m * i / kFilletSteps);
  return ticks;
}

// Sharp box -> rounded box: the inner box's nearest point, plus a fillet radius towards p.
Vec Rounded(const Vec& p, const Vec& half_m) {
  const Vec inner = glm::clamp(p, -half_m + kFillet_m, half_m - kFillet_m);
  return inner + glm::normalize(p - inner) * kFillet_m;
}

// Upright box -> on the dome: below the upper fillet every column is stretched to end on it. z: from the box's middle.
double OnDome(const Vec& p) {
  const double depth = kHeight_m / 2 - p.z;
  const double thick = kTop_m - std::sqrt(kDome_m * kDome_m - p.x * p.x - p.y * p.y);
  const double stretch = (thick - kFillet_m) / (kHeight_m - kFillet_m);
  return kTop_m - (depth < kFillet_m ? depth : kFillet_m + stretch * (depth - kFillet_m));
}

struct Side {
  int axis;  // of its normal
  int sign;
  Face face;  // of its flat part
};
constexpr Side kBlockSides[] = {{2, 1, kTop},   {2, -1, kBody},  {0, 1, kRight},
                                {0, -1, kBody}, {1, -1, kFront}, {1, 1, kBody}};

void AddSide(const Side& side, const Vec& half_m, const std::vector<double> (&ticks)[3], Mesh& mesh) {
  const int u = (side.axis + 1) % 3, v = (side.axis + 2) % 3;
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  const auto columns = static_cast<std::uint32_t>(ticks[u].size()), rows = static_cast<std::uint32_t>(ticks[v].size());
  for (const double b : ticks[v]) {
    for (const double a : ticks[u]) {
      Vec p(0.0);
      p[side.axis] = side.sign * half_m[side.axis];
      p[u] = a;
      p[v] = b;
      const Vec rounded = Rounded(p, half_m);
      mesh.positions.emplace_back(rounded.x, rounded.y, OnDome(rounded));
    }
  }
  for (std::uint32_t j = 0; j + 1 < rows; ++j) {
    for (std::uint32_t i = 0; i + 1 < columns; ++i) {
      const std::uint32_t a = first + j * columns + i, b = a + 1, c = b + columns, d = a + columns;
      const bool flat =
          i >= kFilletSteps && i + 1 + kFilletSteps < columns && j >= kFilletSteps && j + 1 + kFilletSteps < rows;
      const Triangle both[2] = {{a, b, c}, {a, c, d}};
      for (Triangle t : both) {
        if (side.sign < 0) std::swap(t[1], t[2]);
        mesh.triangles.push_back(t);
        mesh.groups.push_back(flat ? side.face : kBody);
      }
    }
  }
}

Mesh BlockMesh() {
  const Vec half_m(kLength_m / 2, kWidth_m / 2, kHeight_m / 2);
  const std::vector<double> ticks[3] = {Ticks(half_m.x, 8), Ticks(half_m.y, 6), Ticks(half_m.z, 3)};
  Mesh mesh;
  for (const Side& side : kBlockSides) AddSide(side, half_m, ticks, mesh);
  Weld(mesh);
  return mesh;
}

}  // namespace

Document ExtrusionScene() {
  const OrderedJson clay = {{"stiffness", 600.0},
                            {"damping", 0.6},
                            {"staticFriction", 0.5},
                            {"dynamicFriction", 0.4},
                            {"sculptable",
                             {{"radius", 0.006},
                              {"falloff", "constant"},
                              {"snap", 0.002},
                              {"grabForce", 0.5},
                              {"dwell", 0.2},
                              {"resistance", 60.0}}}};
  Document document;
  document.title = "extrusion";
  document.materials = {{"block", {0.300, 0.420, 0.560}, 0.6, 0, nullptr, nullptr},
                        {"top", {0.900, 0.420, 0.090}, 0.5, 0, nullptr, nullptr},
                        {"right", {0.130, 0.480, 0.420}, 0.5, 0, nullptr, nullptr},
                        {"front", {0.560, 0.200, 0.330}, 0.5, 0, nullptr, nullptr}};
  document.meshes = {
      {"block", BlockMesh(), {kBody, kTop, kRight, kFront}, {{"MPEG_haptic_material", {{"hapticMaterialIndex", 0}}}}}};
  document.nodes.push_back({"block", 0, Vec(0.0), 0, nullptr, {}});
  document.extensions = {
      {"MPEG_haptic_material",
       {{"materials", OrderedJson::array({{{"name", "clay"}, {"extensions", {{"OMNI_haptic_material", clay}}}}})}}}};
  document.extensions_used = {"MPEG_haptic_material", "OMNI_haptic_material"};
  return document;
}

}  // namespace omni::scenes
