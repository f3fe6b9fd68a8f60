#include "service/haptics/live/scene_changes.h"

#include <algorithm>
#include <cmath>

#include "service/base/material.h"
#include "service/haptics/contact/contact_slots.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

bool IsPlacement(const Placement& placement) noexcept {
  const base::Quat& q = placement.rotation;
  const double norm2 = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
  return std::abs(norm2 - 1) < 1e-6 && IsWithin(placement.translation_m, kFurthestBase_m);
}

Frame PlacementFrame(const Placement& placement) noexcept {
  return {false, placement.rotation, placement.translation_m};
}

// Rows r of a 3x3 (row-major) that act on vectors of the base frame, for those of the scene's: M' = M R.
std::array<double, 9> ActingOnScene(const std::array<double, 9>& M, const Frame& frame) noexcept {
  std::array<double, 9> turned{};
  for (std::size_t r = 0; r < 3; ++r) {
    const Vec3 row = frame.RestDirection({M[3 * r], M[3 * r + 1], M[3 * r + 2]});
    turned[3 * r] = row.x;
    turned[3 * r + 1] = row.y;
    turned[3 * r + 2] = row.z;
  }
  return turned;
}

// The same device in the scene's frame: what force_limit.h computes feasible forces with.
base::ForceLimit InScene(const base::ForceLimit& limit, const Frame& frame) noexcept {
  base::ForceLimit turned = limit;
  turned.ampere_per_newton = ActingOnScene(limit.ampere_per_newton, frame);
  turned.snapping_N = frame.RestDirection(limit.snapping_N);
  const auto& X = limit.newton_per_ampere;
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    const Vec3 column = frame.RestDirection({X[k], X[3 + k], X[6 + k]});
    turned.newton_per_ampere[k] = column.x;
    turned.newton_per_ampere[3 + k] = column.y;
    turned.newton_per_ampere[6 + k] = column.z;
  }
  return turned;
}

// Vectors that were in the scene's frame as it stood, in the frame as it stands: the base frame sees no change.
struct Turn {
  const Frame& before;
  const Frame& now;
  Vec3 operator()(const Vec3& v) const noexcept { return now.RestDirection(before.BaseDirection(v)); }
};

// The frame of an object within its scene.
Frame FrameIn(const State& state, std::uint32_t object) noexcept {
  for (const MovedObject& moved : state.moved) {
    if (moved.object == object) return {false, moved.rotation, moved.translation_m};
  }
  return {};
}

// Contacts end where they were, and their force fades out; ContactScene starts those with what is around the tip in the
// new place.
void Leap(const Frame& before, const Frame& now, bool drives, State& state) noexcept {
  const Turn turn{before, now};
  Vec3 left_N = (state.left_fade_s / kSwapFade_s) * state.left_N;
  for (const ContactState& contact : state.contacts) {
    if (!contact.IsFelt()) continue;
    left_N = left_N + FrameIn(state, contact.object).BaseDirection(contact.last_force_N);
  }
  state.contacts.fill({});
  state.ball_restarts = ~std::uint64_t{0};
  state.left_N = turn(left_N);
  state.left_fade_s = SquaredNorm(left_N) > 1e-12 ? kSwapFade_s : 0;
  state.last_device_point_base_m = now.ToRest(before.ToBase(state.last_device_point_base_m));
  state.energy.has_tip = false;
  state.swing.has_tip = false;
  state.far_distance_m = 0;
  state.ramp = drives ? 0 : state.ramp;  // a stick's spring knows no other place: it fades in there
}

// What the tip does in the scene's frame.
Input InScene(const Input& input, const Frame& before, const Frame& now, bool moves, bool leaps) noexcept {
  Input seen = input;
  seen.device_point_base_m = now.ToRest(input.device_point_base_m);
  Vec3 velocity_m_s = input.velocity_base_m_s;
  if (moves && !leaps && input.dt_s > 0) {
    const Vec3 was_m = before.ToBase(seen.device_point_base_m);
    velocity_m_s = velocity_m_s - (1 / input.dt_s) * (input.device_point_base_m - was_m);
  }
  seen.velocity_base_m_s = now.RestDirection(velocity_m_s);
  seen.axis_base = now.RestDirection(input.axis_base);
  seen.axis_rate_base_1_s = now.RestDirection(input.axis_rate_base_1_s);
  seen.acting.force_N = now.RestDirection(input.acting.force_N);
  seen.limit = InScene(input.limit, now);
  seen.scene_motion = leaps ? SceneMotion::kLeaps : moves ? SceneMotion::kMoves : SceneMotion::kStill;
  return seen;
}

void OutputToBase(const Frame& frame, Output& output) noexcept {
  output.force_base_N = frame.BaseDirection(output.force_base_N);
  for (std::size_t k = 0; k < static_cast<std::size_t>(output.contact_count); ++k) {
    Contact& contact = output.contacts[k];
    contact.point_base_m = frame.ToBase(contact.point_base_m);
    contact.normal_base = frame.BaseDirection(contact.normal_base);
    contact.force_base_N = frame.BaseDirection(contact.force_base_N);
    contact.slip_base_m_s = frame.BaseDirection(contact.slip_base_m_s);
  }
}

}  // namespace

void StepPlaced(const Config& config, const Scene& scene, const Placement& placement, bool leaps, const Input& input,
                State& state, Output& output) noexcept {
  const Placement there = IsPlacement(placement) ? placement : state.placement;
  if (there == Placement{} && state.placement == Placement{} && !leaps) {
    return Step(config, scene, input, state, output);
  }
  const Frame before = PlacementFrame(state.placement), now = PlacementFrame(there);
  const bool moves = !(there == state.placement);
  if (moves) state.last_force_N = Turn{before, now}(state.last_force_N);
  if (leaps) Leap(before, now, !scene.empty() && scene.header().has_joystick != 0, state);
  state.placement = there;
  Step(config, scene, InScene(input, before, now, moves, leaps), state, output);
  OutputToBase(now, output);
}

namespace {

using base::MaterialField;

constexpr const MaterialField& kHum = base::MaterialFieldOf("vibration.amplitude");
constexpr const MaterialField& kHumFrequency = base::MaterialFieldOf("vibration.frequency");

// True: it has not arrived yet.
bool Glide(const MaterialField& field, double wanted, double share, Material& material) noexcept {
  const double before = field.Get(material);
  if (!std::isfinite(wanted) || before == wanted) return false;
  const double now = before + share * (wanted - before);
  const bool arrived = std::abs(wanted - now) <= field.settled;
  field.Set(material, arrived ? wanted : now);
  return !arrived;
}

// The hum's phase is that of the clock, so another frequency jumps in phase: it is applied in silence.
double HumTo(const MaterialParameters& wanted, const Material& now) noexcept {
  const bool other = wanted.vibration_frequency_Hz != now.vibration_frequency_Hz;
  return other && std::isfinite(wanted.vibration_frequency_Hz) ? 0 : wanted.vibration_amplitude_N;
}

bool GlideTo(const MaterialParameters& wanted, double share, Material& now) noexcept {
  bool moving = false;
  for (const MaterialField* field : base::kLiveFields) {
    if (field == &kHumFrequency) continue;
    const double value = field == &kHum ? HumTo(wanted, now) : wanted.*field->live;
    moving |= Glide(*field, std::clamp(value, field->minimum, field->maximum), share, now);
  }
  if (now.vibration_amplitude_N == 0 && std::isfinite(wanted.vibration_frequency_Hz)) {
    moving |= wanted.vibration_amplitude_N > 0 && now.vibration_frequency_Hz != wanted.vibration_frequency_Hz;
    now.vibration_frequency_Hz =
        std::clamp(wanted.vibration_frequency_Hz, kHumFrequency.minimum, kHumFrequency.maximum);
  }
  return moving;
}

// Slots that are in use come first.
LiveMaterial* MaterialSlot(const Scene& scene, std::uint32_t material, State& state) noexcept {
  for (LiveMaterial& live : state.materials) {
    if (live.material == material) return &live;
    if (live.material != kNoIndex) continue;
    live.material = material;
    live.now = scene.materials()[material];
    return &live;
  }
  return nullptr;
}

}  // namespace

bool ChangeMaterials(const Scene& scene, const Input& input, bool touching, State& state) noexcept {
  const double share = touching ? 1 - std::exp(-input.dt_s / kMaterialGlide_s) : 1;
  for (const MaterialChange& change : input.materials) {
    if (change.material < scene.materials().size()) MaterialSlot(scene, change.material, state);
  }
  bool moving = false;
  for (LiveMaterial& live : state.materials) {
    if (live.material == kNoIndex) break;
    const auto named = std::find_if(input.materials.begin(), input.materials.end(),
                                    [&](const MaterialChange& change) { return change.material == live.material; });
    moving |= GlideTo(
        named != input.materials.end() ? named->parameters : base::ParametersOf(scene.materials()[live.material]),
        share, live.now);
  }
  return moving;
}

}  // namespace omni::haptics
