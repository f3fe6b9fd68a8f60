#include "service/protocol/haptic_scene_range.h"

#include <algorithm>
#include <cmath>

#include "service/protocol/sample_range.h"
#include "service/protocol/text.h"

namespace omni::protocol {
namespace {

constexpr const char* kNoNumber = "number is 0";

template <std::size_t n>
bool AllWithin(const std::array<double, n>& values, double limit) noexcept {
  return std::all_of(values.begin(), values.end(), [limit](double x) { return std::abs(x) <= limit; });
}

bool IsUnit(const std::array<double, 4>& q) noexcept {
  const double norm2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
  return std::abs(norm2 - 1) <= 0.02;
}

bool IsTime(std::int64_t t_ns) noexcept { return t_ns >= 0 && t_ns <= kLatestTime_ns; }
bool IsScale(double scale) noexcept { return scale >= kLeastSceneScale && scale <= kMostSceneScale; }

const char* ProblemOf(const ScenePose& pose) noexcept {
  if (!IsUnit(pose.rotation_wxyz)) return "rotation is not a unit quaternion";
  if (!AllWithin(pose.position_m, kMaxScenePosition_m)) return "position_m is not within 1000";
  const bool slow =
      AllWithin(pose.velocity_m_s, kMaxSceneSpeed) && AllWithin(pose.angular_velocity_rad_s, kMaxSceneSpeed);
  return slow ? nullptr : "a velocity is not within 1000";
}

struct FeelRange {
  double HapticFeel::*field;
  double least, most;
  const char* problem;
};
constexpr FeelRange kFeelRanges[] = {
    {&HapticFeel::stiffness_N_m, 0, 2000, "stiffness_N_m is not in 0..2000"},
    {&HapticFeel::damping_Ns_m, 0, 5, "damping_Ns_m is not in 0..5"},
    {&HapticFeel::static_friction, 0, 2, "static_friction is not in 0..2"},
    {&HapticFeel::dynamic_friction, 0, 2, "dynamic_friction is not in 0..2"},
    {&HapticFeel::viscosity_Ns_m, 0, 5, "viscosity_Ns_m is not in 0..5"},
    {&HapticFeel::texture_amplitude_m, 0, 0.002, "texture_amplitude_m is not in 0..0.002"},
    {&HapticFeel::texture_wavelength_m, 0.0001, 0.1, "texture_wavelength_m is not in 0.0001..0.1"},
    {&HapticFeel::texture_gain, 0, 10, "texture_gain is not in 0..10"},
    {&HapticFeel::vibration_amplitude_N, 0, 2, "vibration_amplitude_N is not in 0..2"},
    {&HapticFeel::vibration_frequency_Hz, 1, 500, "vibration_frequency_Hz is not in 1..500"},
    {&HapticFeel::pop_through_N, 0, 10, "pop_through_N is not in 0..10"},
};

}  // namespace

const char* Problem(const HapticSceneLoad& load) noexcept {
  if (load.number == 0) return kNoNumber;
  if ((load.flags & ~(kSceneTouchUntagged | kSceneAllKinematic)) != 0) return "flags are unknown";
  if (!(load.bytes >= 1 && load.bytes <= kMaxHapticSceneBytes)) return "bytes is not in 1..2^28";
  return IsScale(load.scale) ? nullptr : "scale is not in 1e-4..1e4";
}

const char* Problem(const HapticSceneEnd& end) noexcept { return end.number == 0 ? kNoNumber : nullptr; }

const char* Problem(const HapticScenePlace& place) noexcept {
  if (place.number == 0) return kNoNumber;
  if ((place.flags & ~std::uint32_t{kPoseLeaps}) != 0) return "flags are unknown";
  if (!IsTime(place.t_ns)) return "t_ns is no time";
  if (!IsScale(place.scale)) return "scale is not in 1e-4..1e4";
  return ProblemOf(place.pose);
}

const char* Problem(const HapticSceneEnable& enable) noexcept {
  if (enable.number == 0) return kNoNumber;
  return enable.enabled <= 1 ? nullptr : "enabled is neither 0 nor 1";
}

const char* Problem(const HapticNodes& nodes) noexcept {
  if (nodes.number == 0) return kNoNumber;
  if (!(nodes.count >= 1 && nodes.count <= kMaxHapticNodesMoved)) return "count is not in 1..16";
  if (!IsTime(nodes.t_ns)) return "t_ns is no time";
  for (std::uint32_t i = 0; i < nodes.count; ++i) {
    const HapticNodePose& node = nodes.nodes[i];
    if (node.object >= kMaxHapticNodes) return "a node is not below 64";
    if ((node.flags & ~std::uint32_t{kPoseLeaps}) != 0) return "flags are unknown";
    if (const char* problem = ProblemOf(node.pose)) return problem;
  }
  return nullptr;
}

const char* Problem(const HapticMaterial& material) noexcept {
  if (material.number == 0) return kNoNumber;
  if (material.material >= kMaxHapticMaterials) return "material is not below 256";
  return Problem(material.feel);
}

const char* Problem(const HapticSceneState& state) noexcept {
  if (state.number == 0) return kNoNumber;
  if (!(state.status <= HapticSceneStatus::kFailed)) return "status is not 0, 1 or 2";
  if (!IsScale(state.scale)) return "scale is not in 1e-4..1e4";
  return state.load_ns >= 0 ? nullptr : "load_ns is negative";
}

const char* Problem(const HapticSceneTable& table) noexcept {
  if (table.number == 0) return kNoNumber;
  if (table.node_count > kMaxHapticNodes) return "node_count is above 64";
  return table.material_count <= kMaxHapticMaterials ? nullptr : "material_count is above 256";
}

const char* Problem(const HapticNodeRow& row) noexcept {
  if (row.gltf_node < -1) return "gltf_node is below -1";
  if ((row.flags & ~kAllNodeFlags) != 0) return "flags are unknown";
  if (!IsUnit(row.rest_rotation_wxyz)) return "its rest rotation is not a unit quaternion";
  if (!AllWithin(row.rest_position_m, 1e12)) return "its rest position is not within 1e12";
  return IsTerminated(row.name) ? nullptr : "name is not terminated";
}

const char* Problem(const HapticFeel& feel) noexcept {
  for (const FeelRange& range : kFeelRanges) {
    if (!(feel.*range.field >= range.least && feel.*range.field <= range.most)) return range.problem;
  }
  return nullptr;
}

HapticFeel Tamed(const HapticFeel& feel) noexcept {
  HapticFeel tamed;
  for (const FeelRange& range : kFeelRanges) {
    const double value = feel.*range.field;
    tamed.*range.field = std::isnan(value) ? range.least : std::clamp(value, range.least, range.most);
  }
  return tamed;
}

}  // namespace omni::protocol
