#include "service/protocol/haptic_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "service/base/material.h"
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

// For each live field: the problem if it is out of range.
using ProblemText = std::array<char, 80>;
std::array<ProblemText, base::kLiveMaterialFields> MakeParameterProblems() noexcept {
  std::array<ProblemText, base::kLiveMaterialFields> texts{};
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const base::MaterialField& field = *base::kLiveFields[i];
    std::snprintf(texts[i].data(), texts[i].size(), "%.*s is not in %g..%g", static_cast<int>(field.key.size()),
                  field.key.data(), field.minimum, field.maximum);
  }
  return texts;
}

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
  return Problem(material.parameters);
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

const char* Problem(const base::MaterialParameters& parameters) noexcept {
  static const auto kProblems = MakeParameterProblems();
  const std::size_t field = base::FieldOutOfRange(parameters);
  return field < kProblems.size() ? kProblems[field].data() : nullptr;
}

}  // namespace omni::protocol
