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

struct InputObject {
  std::string name;                                     // node name, for people
  std::vector<base::Vec3> vertices_base_m;              // may be unwelded
  std::vector<std::array<std::uint32_t, 3>> triangles;  // counter-clockwise seen from outside
  std::vector<std::uint16_t> triangle_material;         // index into SceneInput::materials, one per triangle
  bool double_sided = false;
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

struct SceneInput {
  std::string name;
  std::vector<Material> materials;  // at least one
  std::vector<InputObject> objects;
  std::optional<JoystickInput> joystick;
  std::optional<VehicleInput> vehicle;
};

}  // namespace omni::haptics
