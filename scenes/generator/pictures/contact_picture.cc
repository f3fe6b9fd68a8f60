#include "scenes/generator/pictures/contact_picture.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <stdexcept>

#include "service/haptics/haptics.h"
#include "service/haptics/state.h"
#include "service/scene/load_scene.h"

namespace omni::scenes {
namespace {

constexpr double kBall_m = 0.0009;
const Vec kProxyColour(0.95, 0.80, 0.10), kTipColour(0.05, 0.07, 0.10), kArrowColour(0.80, 0.05, 0.04),
    kSpringColour(0.25, 0.27, 0.30), kPenColour(0.80, 0.82, 0.85);

constexpr double kPenTip_m = 0.0003, kPenBarrel_m = 0.0022, kPenCone_m = 0.012, kPenLength_m = 0.045;

// Surface of revolution about the line from `start` along `axis` (unit): radius(s) at s of the way to `length`.
template <class Radius>
DrawnMesh Revolved(const Vec& start, const Vec& axis, double length_m, const Vec& colour, int rings, Radius radius) {
  constexpr int kSides = 24;
  const Vec other = std::abs(axis.z) < 0.9 ? Vec(0, 0, 1) : Vec(1, 0, 0);
  const Vec u = glm::normalize(glm::cross(other, axis)), v = glm::cross(axis, u);
  DrawnMesh drawn;
  for (int i = 0; i <= rings; ++i) {
    const double s = static_cast<double>(i) / rings;
    for (int j = 0; j < kSides; ++j) {
      const double angle = 2 * std::numbers::pi * j / kSides;
      drawn.mesh.positions.push_back(start + axis * (s * length_m) +
                                     (u * std::cos(angle) + v * std::sin(angle)) * radius(s));
    }
  }
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < kSides; ++j) {
      const auto at = [](int a, int b) { return static_cast<std::uint32_t>(a * kSides + b % kSides); };
      drawn.mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j + 1)});
      drawn.mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i + 1, j)});
    }
  }
  drawn.normals = VertexNormals(drawn.mesh);
  drawn.mesh.colours.assign(drawn.mesh.positions.size(), colour);
  drawn.roughness = 0.4;
  return drawn;
}

DrawnMesh Ball(const Vec& centre, double radius_m, const Vec& colour) {
  return Revolved(centre - Vec(0, 0, radius_m), Vec(0, 0, 1), 2 * radius_m, colour, 24, [=](double s) {
    return std::max(radius_m * std::sqrt(std::max(0.0, 1 - (2 * s - 1) * (2 * s - 1))), 1e-3 * radius_m);
  });
}

base::Vec3 AsBase(const Vec& p) { return {p.x, p.y, p.z}; }
Vec AsDrawn(const base::Vec3& p) { return {p.x, p.y, p.z}; }

}  // namespace

TouchedContact Touch(const std::string& path, const Vec& from_m, const Vec& tip_m) {
  scene::LoadReport load;
  haptics::BuildReport build;
  const base::Result<haptics::Scene> scene =
      scene::LoadScene(path, {.touch_untagged = true, .tip_radius_m = 0}, nullptr, load, build);
  if (!scene.ok()) throw std::runtime_error(scene.error());
  haptics::Config config;
  haptics::Input input;
  haptics::State state;
  haptics::Output output;
  input.tracked = true;
  input.limit.valid = true;
  input.limit.ampere_per_newton = {5, 0, 0, 0, 5, 0, 0, 0, 5};
  input.limit.current_max_A = {15, 15, 15};
  input.limit.force_max_N = 2;
  haptics::EnterScene(*scene, state);
  for (int tick = 0; tick <= 500; ++tick) {
    const double s = std::min(1.0, tick / 200.0);
    input.device_point_base_m = AsBase(from_m + (tip_m - from_m) * s);
    input.t_ns += 1'000'000;
    haptics::Step(config, *scene, input, state, output);
  }
  if (output.contact_count == 0) throw std::runtime_error(path + ": nothing is touched at the --contact position");
  return {tip_m, AsDrawn(output.contacts[0].point_base_m), AsDrawn(output.force_base_N)};
}

std::vector<DrawnMesh> DrawContact(const TouchedContact& contact, double arrow_m_per_N) {
  std::vector<DrawnMesh> drawn;
  const Vec spring = contact.proxy_m - contact.tip_m;
  drawn.push_back(Ball(contact.proxy_m, kBall_m, kProxyColour));
  drawn.push_back(Ball(contact.tip_m, kBall_m, kTipColour));
  if (glm::length(spring) > 1e-6) {
    drawn.push_back(Revolved(contact.tip_m, glm::normalize(spring), glm::length(spring), kSpringColour, 1,
                             [](double) { return 0.3 * kBall_m; }));
  }
  for (DrawnMesh& mesh : DrawForce(contact.proxy_m, contact.force_N, arrow_m_per_N)) drawn.push_back(std::move(mesh));
  for (DrawnMesh& mesh : drawn) mesh.overlay = true;
  return drawn;
}

std::vector<DrawnMesh> DrawForce(const Vec& tip_m, const Vec& force_N, double arrow_m_per_N) {
  const double length_m = glm::length(force_N) * arrow_m_per_N;
  if (!(length_m > 1e-5)) return {};
  constexpr double kHead = 0.3;  // of the length
  DrawnMesh arrow = Revolved(tip_m, glm::normalize(force_N), length_m, kArrowColour, 100, [](double s) {
    return s < 1 - kHead ? 0.45 * kBall_m : std::max(1.2 * kBall_m * (1 - s) / kHead, 1e-6);
  });
  arrow.overlay = true;
  return {arrow};
}

DrawnMesh DrawPen(const Vec& tip_m, const Vec& axis) {
  return Revolved(tip_m, -glm::normalize(axis), kPenLength_m, kPenColour, 90, [](double s) {
    return std::min(kPenBarrel_m, kPenTip_m + (kPenBarrel_m - kPenTip_m) * s * kPenLength_m / kPenCone_m);
  });
}

}  // namespace omni::scenes
