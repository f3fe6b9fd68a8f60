// Magnet, flange and grip; a nib and a button that applications move (layer/src/models/pen_model.h).
#include "scenes/generator/models/scene_models.h"

#include <cmath>
#include <numeric>

namespace omni::scenes {
namespace {

constexpr double kTurn_rad = 2 * 3.14159265358979323846;
constexpr double kCrease_deg = 35;
constexpr double kBevel_m = 0.0004;
constexpr double kEnd_m = 0.004;           // rounding of the grip's far end
constexpr double kNibDepth_m = 0.003;      // inside of the magnet: the nib stays closed when it is pushed in
constexpr double kButtonCentre_m = 0.040;  // from the tip, where the index finger lies
constexpr double kButtonHalfWidth_m = 0.002, kButtonHalfLength_m = 0.005, kButtonHeight_m = 0.0012;

using Outline = std::vector<Vec>;

// The writer turns its own frame, z up, into glTF's: (x, -z, y) there is (x, y, z) in the document.
Vec InDocument(double x_m, double y_m, double z_m) { return {x_m, -z_m, y_m}; }

// Closed: rings of equally many points, counter-clockwise about the direction in which they follow each other.
Mesh Loft(const std::vector<Outline>& rings) {
  Mesh mesh;
  const auto n = static_cast<std::uint32_t>(rings.front().size());
  for (const Outline& ring : rings) mesh.positions.insert(mesh.positions.end(), ring.begin(), ring.end());
  for (std::uint32_t i = 0; i + 1 < rings.size(); ++i) {
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = i * n + j, b = i * n + (j + 1) % n, c = b + n, d = a + n;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  const auto cap = [&](const Outline& ring, std::uint32_t first, bool turned) {
    const auto centre = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.push_back(std::accumulate(ring.begin(), ring.end(), Vec(0.0)) / static_cast<double>(n));
    for (std::uint32_t j = 0; j < n; ++j) {
      const std::uint32_t a = first + j, b = first + (j + 1) % n;
      mesh.triangles.push_back(turned ? Triangle{centre, b, a} : Triangle{centre, a, b});
    }
  };
  cap(rings.front(), 0, true);
  cap(rings.back(), static_cast<std::uint32_t>(rings.size() - 1) * n, false);
  Weld(mesh);
  return mesh;
}

struct Point {
  double radius_m, z_m;
};

// `profile` from the tip backwards.
Mesh Lathe(const std::vector<Point>& profile, int sides) {
  std::vector<Outline> rings;
  for (const auto& [radius_m, z_m] : profile) {
    Outline& ring = rings.emplace_back();
    for (int k = 0; k < sides; ++k) {
      const double angle_rad = kTurn_rad * k / sides;
      ring.push_back(InDocument(radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), z_m));
    }
  }
  return Loft(rings);
}

std::vector<Point> Disc(double radius_m, double front_m, double back_m) {
  return {{radius_m - kBevel_m, front_m},
          {radius_m, front_m + kBevel_m},
          {radius_m, back_m - kBevel_m},
          {radius_m - kBevel_m, back_m}};
}

Mesh Nib(double radius_m) {
  constexpr int kRings = 4;
  std::vector<Point> profile;
  for (int k = 1; k <= kRings; ++k) {
    const double angle_rad = kTurn_rad / 4 * k / kRings;
    profile.push_back({radius_m * std::sin(angle_rad), radius_m * (1 - std::cos(angle_rad))});
  }
  profile.insert(profile.begin(), {0, 0});
  profile.push_back({radius_m, radius_m + kNibDepth_m});
  return Lathe(profile, 16);
}

Mesh Grip(const PenShape& shape, double flange_m) {
  const double radius_m = shape.grip_diameter_m / 2, front_m = flange_m + shape.flange_m;
  const double back_m = front_m + shape.grip_length_m;
  std::vector<Point> profile = Disc(shape.magnet_radius_m, flange_m, front_m);
  profile.insert(profile.end(), {{radius_m, front_m}, {radius_m, back_m - kEnd_m}});
  for (int k = 1; k <= 3; ++k) {
    const double angle_rad = kTurn_rad / 4 * k / 3;
    profile.push_back({radius_m - kEnd_m * (1 - std::cos(angle_rad)), back_m - kEnd_m * (1 - std::sin(angle_rad))});
  }
  return Lathe(profile, 24);
}

// A chamfered bar across the grip's upper side, its lower face inside the grip.
Mesh Button(double grip_radius_m) {
  const auto ring = [](double height_m, double inset_m) {
    const double x_m = kButtonHalfWidth_m - inset_m, z_m = kButtonHalfLength_m - inset_m;
    constexpr double kCorner_m = 0.0008;
    Outline out;
    const double corners[8][2] = {{kCorner_m - x_m, z_m},  {x_m - kCorner_m, z_m},  {x_m, z_m - kCorner_m},
                                  {x_m, kCorner_m - z_m},  {x_m - kCorner_m, -z_m}, {kCorner_m - x_m, -z_m},
                                  {-x_m, kCorner_m - z_m}, {-x_m, z_m - kCorner_m}};
    for (const auto& [x, z] : corners) out.push_back(InDocument(x, height_m, kButtonCentre_m + z));
    return out;
  };
  const double top_m = grip_radius_m + kButtonHeight_m;
  return Loft({ring(grip_radius_m - 2 * kButtonHeight_m, 0), ring(top_m - kBevel_m, 0), ring(top_m, kBevel_m)});
}

}  // namespace

Document PenModel(const PenShape& shape) {
  const double face_m = shape.tip_offset_m - shape.magnet_half_height_m;
  const double back_m = shape.tip_offset_m + shape.magnet_half_height_m;
  const auto drawn = [](const Mesh& mesh) { return SplitCreases(mesh, kCrease_deg); };
  Document document;
  document.title = "pen";
  document.materials = {{.name = "nickel", .colour = {0.66, 0.61, 0.53}, .roughness = 0.3, .metallic = 1},
                        {.name = "grip", .colour = {0.03, 0.03, 0.035}, .roughness = 0.6},
                        {.name = "nib", .colour = {0.8, 0.8, 0.8}, .roughness = 0.5},
                        {.name = "button", .colour = {0.9, 0.25, 0.02}, .roughness = 0.5}};
  document.meshes = {
      {.name = "magnet", .mesh = drawn(Lathe(Disc(shape.magnet_radius_m, face_m, back_m), 24)), .materials = {0}},
      {.name = "grip", .mesh = drawn(Grip(shape, back_m)), .materials = {1}},
      {.name = "tip", .mesh = drawn(Nib(face_m)), .materials = {2}},
      {.name = "button", .mesh = drawn(Button(shape.grip_diameter_m / 2)), .materials = {3}}};
  document.nodes = {{.name = "pen", .mesh = {}, .children = {1, 2, 3, 4}}};
  for (std::uint32_t k = 0; k < document.meshes.size(); ++k)
    document.nodes.push_back({.name = document.meshes[k].name, .mesh = k, .children = {}});
  return document;
}

}  // namespace omni::scenes
