// Meshes made by formula, and a pen that plays a scenario tick by tick.
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <utility>

#include "service/base/vec.h"
#include "service/haptics/haptics.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"
#include "tests/support/usual_limit.h"

namespace omni::haptics {

using base::Vec3;

inline void AddTriangle(InputObject& object, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  object.triangles.push_back({a, b, c});
  object.triangle_material.push_back(0);
}

// Cube surface, n x n squares a side, every vertex mapped by `place` from its unit direction-ish point in [-1, 1]^3.
inline InputObject CubeGrid(int n, const std::function<Vec3(const Vec3&)>& place) {
  InputObject object;
  object.name = "grid";
  for (int face = 0; face < 6; ++face) {
    const auto base = static_cast<std::uint32_t>(object.vertices_base_m.size());
    const double sign = face % 2 == 0 ? 1 : -1;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double u = 2.0 * i / n - 1, v = 2.0 * j / n - 1;
        const Vec3 p = face / 2 == 0 ? Vec3{sign, u, v} : (face / 2 == 1 ? Vec3{v, sign, u} : Vec3{u, v, sign});
        object.vertices_base_m.push_back(place(p));
      }
    }
    const auto row = static_cast<std::uint32_t>(n + 1);
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      for (std::uint32_t j = 0; j + 1 < row; ++j) {
        const std::uint32_t a = base + i * row + j, b = a + row, c = b + 1, d = a + 1;
        if (sign > 0) {
          AddTriangle(object, a, b, c);
          AddTriangle(object, a, c, d);
        } else {
          AddTriangle(object, a, c, b);
          AddTriangle(object, a, d, c);
        }
      }
    }
  }
  return object;
}

inline InputObject Sphere(int n, double radius_m) {
  return CubeGrid(n, [=](const Vec3& p) { return radius_m * Normalized(p); });
}

inline InputObject Block(int n, const Vec3& half_m, const Vec3& centre_m = {}) {
  return CubeGrid(n, [=](const Vec3& p) { return centre_m + Vec3{half_m.x * p.x, half_m.y * p.y, half_m.z * p.z}; });
}

// Surface of the parameters u, v in [0, 2 pi), periodic in both (torus-like).
inline InputObject Periodic(int nu, int nv, const std::function<Vec3(double, double)>& place) {
  InputObject object;
  object.name = "periodic";
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      object.vertices_base_m.push_back(place(2 * std::numbers::pi * i / nu, 2 * std::numbers::pi * j / nv));
    }
  }
  const auto at = [=](int i, int j) { return static_cast<std::uint32_t>((i % nu) * nv + j % nv); };
  for (int i = 0; i < nu; ++i) {
    for (int j = 0; j < nv; ++j) {
      AddTriangle(object, at(i, j), at(i + 1, j), at(i + 1, j + 1));
      AddTriangle(object, at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  }
  return object;
}

inline Vec3 TorusPoint(double major_m, double minor_m, double u, double v) {
  const double r = major_m + minor_m * std::cos(v);
  return {r * std::cos(u), r * std::sin(u), minor_m * std::sin(v)};
}

inline SceneInput SceneOf(InputObject object, const Material& material = {}) {
  SceneInput input;
  input.name = "test";
  input.materials.push_back(material);
  input.objects.push_back(std::move(object));
  return input;
}

inline Scene Built(const SceneInput& input) {
  BuildReport report;
  base::Result<Scene> scene = BuildScene(input, report);
  return scene.ok() ? scene.value() : Scene();
}

// splitmix64: the same numbers everywhere.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t Next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }
  double Uniform(double low, double high) { return low + (high - low) * 0x1p-53 * static_cast<double>(Next() >> 11); }
  Vec3 InBox(double half) { return {Uniform(-half, half), Uniform(-half, half), Uniform(-half, half)}; }

 private:
  std::uint64_t state_;
};

// A pen in a scene. The stability rule is relaxed, so that a material renders with its own stiffness.
class Pen {
 public:
  explicit Pen(Scene scene) : scene_(std::move(scene)) {
    config.delay_s = 0;
    config.coil_lag_s = 0;
    config.predict_max_s = 0;
    config.ramp_s = 0;
    input.limit = test::UsualLimit();
    input.tracked = true;
    EnterScene(scene_, state);
  }

  const Output& MoveTo(const Vec3& tip) {
    input.velocity_base_m_s = state.was_tracked ? (1 / input.dt_s) * (tip - state.last_device_point_base_m) : Vec3{};
    input.device_point_base_m = tip;
    input.t_ns += 1'000'000;
    Step(config, scene_, input, state, output);
    return output;
  }
  const Output& Slide(const Vec3& from, const Vec3& to, int ticks) {
    for (int k = 1; k <= ticks; ++k) MoveTo(from + (static_cast<double>(k) / ticks) * (to - from));
    return output;
  }
  const Output& Rest(int ticks) {
    for (int k = 0; k < ticks; ++k) MoveTo(state.last_device_point_base_m);
    return output;
  }
  const Output& Lose() {
    input.tracked = false;
    Step(config, scene_, input, state, output);
    input.tracked = true;
    return output;
  }
  void Swap(Scene scene) {
    scene_ = std::move(scene);
    EnterScene(scene_, state);
  }
  const Scene& scene() const { return scene_; }

  Config config;
  Input input;
  State state;
  Output output;

 private:
  Scene scene_;
};

}  // namespace omni::haptics
