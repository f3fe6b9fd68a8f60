// What a scene file says, before it is made fit for the tick. The seam between scene/ (reads glTF, knows nothing of
// haptics) and haptics/ (BuildScene welds, orients, indexes).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/material.h"

namespace omni::haptics {

inline constexpr std::size_t kMaxUvSets = 2;

// Texture coordinates of a triangle's corners: u0, v0, u1, v1, u2, v2; (0, 0) is the image's upper left corner.
using CornerUv = std::array<float, 6>;

struct InputObject {
  std::string name;                                     // node name, for people
  std::string source;                                   // where it comes from, for messages: a JSON pointer
  std::vector<base::Vec3> vertices_base_m;              // may be unwelded
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
  std::vector<std::uint16_t> triangle_material;         // index into SceneInput::materials, one per triangle
  std::array<std::vector<CornerUv>, kMaxUvSets> uv;     // per triangle; a set no texture needs is empty
  bool double_sided = false;
  bool kinematic = false;  // the application moves it
  bool collidable = true;  // false: never touched by the tip (e.g. the car, its road)
  bool car_wall = false;   // the vehicle collides with it
};

// "joystick": the tip is drawn to a centre; its displacement is the thumbstick.
struct JoystickInput {
  base::Vec3 centre_base_m;
  double stiffness_N_m = 60;    // [0, 500]
  double damping_Ns_m = 0.4;    // [0, 5]
  double range_m = 0.015;       // full deflection, (0, 0.05]
  double dead_zone_m = 0.0015;  // [0, range)
};

// "vehicle": a car on the plane z = start.z, steered by the joystick, hit by objects with car_wall.
struct VehicleInput {
  base::Vec3 start_base_m;
  double start_heading_rad = 0;  // about +z, 0 = +x
  double radius_m = 0.002;       // collision radius
  double wheelbase_m = 0.004;
  double speed_max_m_s = 0.08;
  double acceleration_m_s2 = 0.15;
  double steer_max_rad = 0.6;
  double hit_force_N = 0.8;      // pulse amplitude at high impact speed
  double hit_speed_m_s = 0.05;   // J = hit_force (1 - exp(-v / hit_speed))
  double hit_duration_s = 0.03;  // half sine
};

enum class Wrap : std::uint8_t { kRepeat = 0, kClamp = 1, kMirror = 2 };

// One channel of an image, linear: 0..255 stands for 0..1. Rows from the top.
struct InputImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> texels;  // width x height
};

// How a material looks an image up.
struct InputTexture {
  std::uint32_t image = 0;   // index into SceneInput::images
  std::uint32_t uv_set = 0;  // below kMaxUvSets
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  std::array<double, 6> to_image{1, 0, 0, 0, 1, 0};  // u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5
};

struct SceneInput {
  std::string name;
  std::vector<Material> materials;  // at least one
  std::vector<InputObject> objects;
  std::vector<InputImage> images;
  std::vector<InputTexture> textures;
  double tip_radius_m = 0;  // [0, 0.01]: the tip is a ball of this radius; 0: a point
  std::optional<JoystickInput> joystick;
  std::optional<VehicleInput> vehicle;
};

}  // namespace omni::haptics
