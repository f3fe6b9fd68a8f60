// What a scene file says, before BuildScene prepares it for the tick. The interface between scene/ (reads glTF, knows
// nothing of haptics) and haptics/ (BuildScene welds, orients, indexes).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/vec.h"
#include "service/haptics/scene/material.h"

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
  double stiffness_N_m = 60;     // [0, 500]
  double damping_Ns_m = 0.4;     // [0, 5]
  double range_m = 0.015;        // full deflection, (0, 0.05]
  double dead_zone_m = 0.0015;   // [0, range)
  double detent_force_N = 0.03;  // of the notches below, [0, 0.5]
  int radial_detents = 0;        // notches between dead zone and range, the last one at range; [0, 8]
  int angular_detents = 0;       // directions the stick prefers, the first one ahead (+y); [0, 16]
};

inline constexpr int kMaxCheckpoints = 16;  // of a scene; the loader ignores further ones, with a warning

// A line across the road: passed when the car crosses it in its direction, within its width.
struct Checkpoint {
  base::Vec3 position_base_m;
  double heading_rad = 0;  // about +z, 0 = +x
  double width_m = 0.04;   // (0, 10]
};

// "vehicle": a car on the plane z = start.z, steered by the joystick, hit by objects with car_wall. Tyres by grip and
// slip per load, so that they do not change with the size of the model. docs/theory/haptics.md, section 8.
struct VehicleInput {
  base::Vec3 start_base_m;       // centre of mass
  double start_heading_rad = 0;  // about +z, 0 = +x
  double radius_m = 0.002;       // collision radius
  double wheelbase_m = 0.004;
  double speed_max_m_s = 0.08;
  double acceleration_m_s2 = 0.15;  // from a standstill, grip permitting
  double steer_max_rad = 0.6;
  double grip_g = 0.15;                      // largest acceleration by the tyres, (0, 10]
  double slip_stiffness_front_per_rad = 3;   // side force over load, per slip angle, (0, 100]
  double slip_stiffness_rear_per_rad = 3.6;  // larger than in front: understeers
  double front_share = 0.5;                  // of the weight on the front axle, [0.1, 0.9]
  double inertia = 1;                        // radius of gyration^2 / (axle distances from the centre), [0.1, 10]
  double hit_force_N = 0.8;                  // pulse amplitude at high impact speed
  double hit_speed_m_s = 0.05;               // J = hit_force (1 - exp(-v / hit_speed))
  double hit_duration_s = 0.03;              // half sine
  double hit_to_base = 0;                    // share of a hit that pushes to the base, not off the wall, [0, 1]
  double engine_force_N = 0.02;              // hum at full speed, [0, 0.1]
  double engine_frequency_Hz = 90;           // at full speed, [0, 150]
  double road_force_N = 0.03;                // ripple of the road, [0, 0.1]
  double road_wavelength_m = 0.001;          // > 0
  double start_line_m = 0;                   // the line laps are counted at is so far ahead of the start
  double line_width_m = 0.04;                // of that line, (0, 10]
  std::array<Checkpoint, kMaxCheckpoints> checkpoints;  // in the order they are passed
  int checkpoint_count = 0;
  int reserved = 0;  // no padding: the scene's hash covers these bytes
};

enum class Wrap : std::uint8_t { kRepeat = 0, kClamp = 1, kMirror = 2 };

// One channel of an image, linear: 0..255 stands for 0..1. Rows from the top.
struct InputImage {
  std::uint32_t width = 0, height = 0;
  std::vector<std::uint8_t> texels;  // width x height
};

// How a material samples an image.
struct InputTexture {
  std::uint32_t image = 0;   // index into SceneInput::images
  std::uint32_t uv_set = 0;  // below kMaxUvSets
  Wrap wrap_u = Wrap::kRepeat, wrap_v = Wrap::kRepeat;
  std::array<double, 6> to_image{1, 0, 0, 0, 1, 0};  // u' = t0 u + t1 v + t2, v' = t3 u + t4 v + t5
};

inline constexpr std::size_t kMaxReliefBands = 10;    // 512 down to 1 texels wide
inline constexpr std::uint32_t kMaxReliefSide = 512;  // texels; larger images are averaged

// Heights as bands, the finest first, each half as wide and high as the one before, down to one texel. A texel t of a
// band stands for (t - 128) x its step, in widths of a texel of the image   (T.3).
struct InputRelief {
  std::uint32_t width = 0, height = 0;  // of the finest band: powers of two, at most kMaxReliefSide
  std::uint32_t image_width = 0, image_height = 0;
  std::vector<float> steps;  // one per band
  InputTexture texture;      // its image has one row: the texels of all bands, one after the other
};

// Texels of all bands.
constexpr std::uint64_t ReliefTexels(std::uint32_t width, std::uint32_t height, std::size_t bands) noexcept {
  std::uint64_t sum = 0;
  for (std::size_t k = 0; k < bands; ++k)
    sum += std::uint64_t{std::max(width >> k, 1U)} * std::uint64_t{std::max(height >> k, 1U)};
  return sum;
}

struct SceneInput {
  std::string name;
  std::vector<Material> materials;  // at least one
  std::vector<InputObject> objects;
  std::vector<InputImage> images;
  std::vector<InputTexture> textures;
  std::vector<InputRelief> reliefs;
  double tip_radius_m = 0;  // [0, 0.01]: the tip is a ball of this radius; 0: a point
  std::optional<JoystickInput> joystick;
  std::optional<VehicleInput> vehicle;
};

}  // namespace omni::haptics
