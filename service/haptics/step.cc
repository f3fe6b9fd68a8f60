// Enter and Step: the order of a tick.
#include <cstddef>
#include <cstring>

#include "service/base/force_limit.h"
#include "service/haptics/contact/contact_scene.h"
#include "service/haptics/contact/contacts.h"
#include "service/haptics/contact/effects.h"
#include "service/haptics/extrude/extrude.h"
#include "service/haptics/geometry/query.h"
#include "service/haptics/geometry/topology.h"
#include "service/haptics/haptics.h"
#include "service/haptics/live/scene_changes.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/stability/contact_watch.h"
#include "service/haptics/stability/stability.h"
#include "service/haptics/state.h"
#include "service/haptics/vehicle/car.h"

namespace omni::haptics {
namespace {

constexpr double kFarthestTip_m = 100;  // a tip beyond is not a measurement
constexpr double kFastestTip_m_s = 1e3;
constexpr double kLongestTick_s = 5e-3;
constexpr double kGapMax_s = 25e-3;  // ticks without a pose that end no contact
constexpr double kLeap_m = 0.5;      // 20 m/s over such a gap; further is another place
constexpr double kFast_m = 0.01;     // in one tick: faster than a hand, so the force fades in, whatever was entered
constexpr double kFastestTurn_1_s = 1e3;

// Resets an output that is new or of an earlier tick: its contacts beyond the count are reset already, and are most of
// its bytes.
void Clear(Output& output) noexcept {
  static constexpr Output kNew;
  constexpr std::size_t kHead = offsetof(Output, contacts), kTail = kHead + sizeof(Output::contacts);
  const int used = std::clamp(output.contact_count, 0, kMaxContacts);
  for (int k = 0; k < used; ++k) output.contacts[static_cast<std::size_t>(k)] = {};
  auto* to = reinterpret_cast<std::byte*>(&output);
  const auto* from = reinterpret_cast<const std::byte*>(&kNew);
  std::memcpy(to, from, kHead);
  std::memcpy(to + kTail, from + kTail, sizeof(Output) - kTail);
}

bool IsClean(const Input& input) noexcept {
  return input.dt_s >= 0 && input.dt_s <= kLongestTick_s && input.tracked &&
         IsWithin(input.device_point_base_m, kFarthestTip_m) && IsWithin(input.velocity_base_m_s, kFastestTip_m_s);
}

// The input without values that cannot be used.
Input Cleaned(const Input& input) noexcept {
  Input clean = input;
  clean.dt_s = input.dt_s >= 0 ? std::min(input.dt_s, kLongestTick_s) : 0;
  clean.tracked = input.tracked && IsWithin(input.device_point_base_m, kFarthestTip_m);
  if (!clean.tracked) clean.device_point_base_m = {};
  if (!IsWithin(input.velocity_base_m_s, kFastestTip_m_s)) clean.velocity_base_m_s = {};
  return clean;
}

// From the centre of the ball at the tip to the device point, its lowest point.
struct BallArm {
  Vec3 to_tip_m, rate_m_s;
};

// c = x - r u   (12.14)
BallArm BallArmOf(const Scene& scene, const Input& input) noexcept {
  const double radius_m = scene.empty() ? 0 : TipRadius_m(scene);
  const bool known = IsWithin(input.axis_base, 1.001) && IsWithin(input.axis_rate_base_1_s, kFastestTurn_1_s);
  if (!(radius_m > 0 && known)) return {};
  return {radius_m * input.axis_base, radius_m * input.axis_rate_base_1_s};
}

// The input with the ball's centre in place of the device point: all contact is there.
Input AtCentre(const Input& input, const BallArm& arm) noexcept {
  Input centre = input;
  centre.device_point_base_m = input.device_point_base_m - arm.to_tip_m;
  centre.velocity_base_m_s = input.velocity_base_m_s - arm.rate_m_s;
  return centre;
}

bool AnyContact(const State& state) noexcept {
  if (state.far_distance_m > 0) return false;  // set only while nothing is touched
  return std::any_of(state.contacts.begin(), state.contacts.end(), [](const ContactState& c) { return c.active; });
}

// What is active only hovers over surfaces: magnets act.
bool OnlyHovers(const State& state) noexcept {
  return std::all_of(state.contacts.begin(), state.contacts.end(),
                     [](const ContactState& c) { return !c.active || (c.in_flight && !c.popped); });
}

bool RegionsRest(const Scene& scene, const State& state) noexcept {
  for (std::size_t r = 0; r < scene.regions().size(); ++r) {
    if (state.regions[r].phase != ExtrudePhase::kFree || state.regions[r].offset_m != state.regions[r].last_offset_m) {
      return false;
    }
  }
  return true;
}

// Motion bound: the tip is still within a ball in which there is nothing to touch   (2.4)
bool StillFar(const Vec3& tip, const State& state) noexcept {
  return state.was_tracked && Norm(tip - state.far_origin_base_m) < state.far_distance_m;
}

bool IsDented(const State& state) noexcept {
  return std::any_of(state.soft.begin(), state.soft.end(), [](const SoftTouch& s) { return s.object != kNoIndex; });
}

// No surface changes by itself: none is edited, pushed, moved or dented, and no lost contact fades out. A soft body is
// adopted when the tip comes near.
bool IsStill(const Scene& scene, const Input& input, const State& state) noexcept {
  return scene.regions().empty() && input.poses.empty() && state.moved[0].object == kNoIndex &&
         !(state.left_fade_s > 0) && (scene.live() == nullptr || (!IsDented(state) && SurfacesRest(scene, state)));
}

// The scene has no effect on a tip there.
bool NothingHere(const Scene& scene, const Input& input, const Vec3& tip, const State& state) noexcept {
  if (scene.empty()) return true;
  const bool drives = scene.header().has_joystick != 0 || scene.header().has_vehicle != 0;
  return !drives && IsStill(scene, input, state) && (!input.tracked || StillFar(tip, state));
}

// Distance to what can be touched. Renews the motion bound and returns the pull of a magnetic surface.
Vec3 LookAround(const ContactScene& contact_scene, double stiffness_limit_N_m, const Vec3& tip, State& state) noexcept {
  constexpr double kNowhere_m = 1e3;
  constexpr double kMargin_m = 2e-6;  // longer than sweeps are back-dated
  const Scene& scene = contact_scene.scene();
  double distance_m = kNowhere_m;
  Vec3 towards;
  const Material* material = nullptr;
  double skin_m = 0;
  for (std::uint32_t i = 0; i < scene.objects().size(); ++i) {
    const Target target = contact_scene.TargetOf(i);
    if ((target.object.flags & kCollidable) == 0) continue;
    skin_m = std::max(skin_m, contact_scene.TipAt(i).skin_m);
    if (target.boxed && !(BoxDistance(target.object, target.tip) < distance_m)) continue;
    contact_scene.VisitSurface(i, [&](const auto& view) noexcept {
      const NearestResult found = NearestInTree(view, target.root, target.tip, distance_m);
      if (found.triangle == kNoIndex) return;
      distance_m = std::sqrt(found.closest.distance_squared);
      towards = contact_scene.FrameOf(i).BaseDirection(found.closest.point - target.tip);
      material = &scene.materials()[view.GetTriangle(found.triangle).material];
    });
  }
  const double gap_m = distance_m - contact_scene.tip_radius_m();
  state.far_origin_base_m = tip;
  state.far_distance_m = std::max(0.0, gap_m - skin_m - scene.header().magnet_range_m - kMargin_m);
  if (material == nullptr || !(gap_m < scene.header().magnet_range_m)) return {};
  const MagnetEffect magnet{material->magnet_max_force_N, material->magnet_range_m};
  return magnet.ForceOn(gap_m, stiffness_limit_N_m) * Normalized(towards);
}

// What the contacts request, before limits.
struct Touched {
  Vec3 contacts_N;
  Vec3 others_N;             // of magnets and of faces that are held or pushed
  double stored_J = 0;       // in the contacts' springs
  double stiffness_N_m = 0;  // of the stiffest of them
  bool moving = false;       // a surface moves by itself
};

// Sums up what the contacts request and reports them.
Vec3 Collect(const ContactForces& forces, double ramp, const State& state, Touched& touched, Output& output) noexcept {
  Vec3 sum;
  double stiffest_N_m = 0;
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    if (!state.contacts[k].IsFelt()) continue;
    const ContactForce& force = forces.of[k];
    sum = sum + force.force_N;
    touched.stored_J += 0.5 * force.elastic_N * force.depth_m;
    if (force.depth_m > 0) touched.stiffness_N_m = std::max(touched.stiffness_N_m, force.elastic_N / force.depth_m);
    output.contacts[static_cast<std::size_t>(output.contact_count++)] = force.report;
    output.tip_normal_force_N += ramp * force.report.normal_force_N;
    if (force.asked_stiffness_N_m > stiffest_N_m) {
      stiffest_N_m = force.asked_stiffness_N_m;
      output.stiffness_cut = force.stiffness_cut;
    }
  }
  return sum;
}

// Follows the contacts to the tip and gives their forces.
ContactForces Follow(const ContactScene& contact_scene, const StiffnessBound& bound, const Input& input,
                     const Vec3& on_changed_N, State& state) noexcept {
  if (state.was_tracked) {
    UpdateContacts(contact_scene, input.dt_s, state);
  } else {
    StartContacts(contact_scene, state);
  }
  if (contact_scene.anything_moves()) StartLeaving(contact_scene, on_changed_N, state);
  return ForcesOf(bound, contact_scene, input, state);
}

using RegionTouches = std::array<RegionTouch, kMaxRegions>;

RegionTouches TouchesOf(const ContactScene& contact_scene, const ContactForces& forces, const State& state) noexcept {
  RegionTouches touches{};
  if (contact_scene.surface().region_count() == 0) return touches;
  for (std::size_t k = 0; k < kMaxContacts; ++k) {
    const ContactState& contact = state.contacts[k];
    if (!contact.IsFelt() || contact_scene.TableOf(contact.object) != nullptr) continue;
    const std::uint32_t region = contact_scene.surface().RegionOf(contact.triangle);
    if (region != kNoIndex) touches[region] = {forces.of[k].elastic_N, forces.of[k].depth_m};
  }
  return touches;
}

bool Holds(const Scene& scene, const State& state) noexcept {
  for (std::size_t r = 0; r < scene.regions().size(); ++r) {
    if (state.regions[r].phase == ExtrudePhase::kHeld) return true;
  }
  const std::size_t tools = scene.live() == nullptr ? 0 : std::min(scene.live()->sculpt_session_count(), kMaxSculpted);
  for (std::size_t n = 0; n < tools; ++n) {
    if (state.sculpted[n].tool.phase == sculpt::SculptPhase::kHeld) return true;
  }
  return false;
}

// What the tip is inside of without force, until it was outside.
bool Waits(const State& state) noexcept {
  return std::any_of(state.contacts.begin(), state.contacts.end(), [](const auto& c) { return c.active && c.popped; });
}

// Faces that are pushed in and pulled out; their force on the tip, base frame.
Vec3 StepRegions(const ContactScene& contact_scene, const StiffnessBound& bound, const Input& input,
                 const RegionTouches& touches, State& state) noexcept {
  const auto regions = contact_scene.scene().regions();
  Vec3 sum;
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const Region& region = regions[r];
    const Target target = contact_scene.TargetOf(region.object);
    const Frame frame = contact_scene.FrameOf(region.object);
    const ExtrudeInput extrude{input.tracked, target.tip, frame.RestDirection(input.velocity_base_m_s), input.dt_s,
                               bound.stiffness_N_m};
    const Extrude& feel = contact_scene.scene().materials()[region.material].extrude;
    sum = sum + frame.BaseDirection(StepRegion(region, feel, touches[r], extrude, state.regions[r]));
  }
  return sum;
}

// The tip's contact forces, and what they do to surfaces that can be formed.
Touched Touch(const Scene& scene, const StiffnessBound& bound, const Input& input, State& state,
              Output& output) noexcept {
  const Vec3 tip = input.device_point_base_m;
  if (IsStill(scene, input, state) && (!input.tracked || StillFar(tip, state))) return {};
  const bool live_materials = !input.materials.empty() || state.materials[0].material != kNoIndex;
  const bool changed_feel = live_materials && ChangeMaterials(scene, input, AnyContact(state), state);
  const ContactScene contact_scene(scene, input, state);
  Touched touched;
  const Vec3 on_changed_N = contact_scene.anything_moves() ? ForceOnChanged(contact_scene, state) : Vec3{};
  if (contact_scene.anything_moves()) RebindContacts(contact_scene, state);
  touched.moving = contact_scene.anything_moves() || !RegionsRest(scene, state) || changed_feel;
  if (touched.moving) state.far_distance_m = 0;
  ContactForces forces;
  RegionTouches touches{};
  if (!StillFar(tip, state) || !ToolsRest(scene, state)) {
    if (input.tracked) forces = Follow(contact_scene, bound, input, on_changed_N, state);
    touched.others_N = StepSculptTools(bound, contact_scene, input, forces, state);
    if (input.tracked) touched.contacts_N = Collect(forces, state.ramp, state, touched, output);
    if (input.tracked) touches = TouchesOf(contact_scene, forces, state);
    state.far_distance_m = 0;
    if (input.tracked && OnlyHovers(state)) {
      const bool hovers = AnyContact(state);
      touched.others_N = touched.others_N + LookAround(contact_scene, bound.stiffness_N_m, tip, state);
      if (hovers) state.far_distance_m = 0;  // of a ball that is on its way
    }
  }
  touched.others_N = touched.others_N + StepRegions(contact_scene, bound, input, touches, state);
  output.holding = Holds(scene, state);
  output.waits = Waits(state);
  touched.moving = touched.moving || !RegionsRest(scene, state) || input.scene_motion != SceneMotion::kStill;
  if (state.left_fade_s > 0) touched.others_N = touched.others_N + FadeLeaving(input.dt_s, state);
  ForgetUntouched(state);
  return touched;
}

// Vector scaling to what the device can do, then the slew limit. Where the limit itself falls faster than the slew, the
// limit wins; where nothing is known about it (no pose), the force fades out under the slew.   (10.1), (10.2)
void Limit(const Config& config, const Input& input, const Vec3& wanted_N, State& state, Output& output) noexcept {
  state.felt_share = 1;
  if (wanted_N == Vec3{} && state.last_force_N == Vec3{}) return;  // a far tip costs nothing
  const bool known = input.tracked && input.limit.valid;
  const double scale = known ? base::FeasibleScale(input.limit, wanted_N) : 0;
  output.saturated = known && scale < 1;
  state.felt_share = scale;
  const Vec3 target_N = scale > 0 ? scale * wanted_N : Vec3{};
  const Vec3 change_N = target_N - state.last_force_N;
  const double most_N = std::max(0.0, config.force_slew_N_s) * input.dt_s;
  const double size_N = Norm(change_N);
  Vec3 force_N = size_N > most_N ? state.last_force_N + (most_N / size_N) * change_N : target_N;
  if (known) {
    const double again = base::FeasibleScale(input.limit, force_N);
    if (again < 1) force_N = again * force_N;
  }
  if (!IsWithin(force_N, 1e3)) force_N = {};
  state.last_force_N = force_N;
  output.force_base_N = force_N;
  output.in_contact = Norm(force_N) > config.contact_threshold_N;
}

// A pen that is away for no longer than kGapMax_s goes on where it was: contacts keep the side they were entered from.
// After a longer absence, or a jump that no hand makes, nothing is known. Either way the force fades in again. True:
// the motion since the last tick is one that a hand makes.
bool Remember(const Config& config, const Input& input, State& state) noexcept {
  const double moved_m = Norm(input.device_point_base_m - state.last_device_point_base_m);
  const bool leapt = input.tracked && state.was_tracked && !(moved_m < kLeap_m);
  const bool gone = !input.tracked && (state.away_s += input.dt_s) > kGapMax_s;
  const bool steady = input.tracked && state.was_tracked && moved_m < kFast_m;
  if (!steady) {
    state.ramp = config.ramp_s > 0 ? 0 : 1;
    state.far_distance_m = 0;
  }
  if (input.tracked) state.away_s = 0;
  if (leapt || gone || !state.was_tracked) {
    state.was_tracked = false;
    state.contacts.fill({});
  }
  return steady;
}

// Nothing but contacts acts on the hand.
bool IsAlone(const Input& input, bool steady, const State& state) noexcept {
  return steady && state.ramp == 1 && !input.pushed && !input.constrained;
}

// A spring K d that a limit cuts to the share s has taken up K d^2 (s - s^2 / 2).
double Watch(const Input& measured, const Touched& touched, bool steady, bool passive, State& state) noexcept {
  const double share = state.felt_share;
  return WatchContacts({.tip = measured.device_point_base_m,
                        .velocity_m_s = measured.velocity_base_m_s,
                        .dt_s = measured.dt_s,
                        .noise_m = std::sqrt(std::max(0.0, measured.noise.position_m2)),
                        .velocity_noise_m_s = std::sqrt(std::max(0.0, measured.noise.velocity_m2_s2)),
                        .force_N = touched.contacts_N,
                        .stiffness_N_m = touched.stiffness_N_m,
                        .stored_J = measured.acting.share * share * (2 - share) * touched.stored_J,
                        .acting = measured.acting,
                        .judged = steady && !touched.moving && !measured.pushed,
                        .passive = passive},
                       state.swing, state.energy);
}

// The scene's force, and as much of it as the limits allow. A stick follows the device point itself.
void Render(const Config& config, const StiffnessBound& bound, const Scene& scene, const Input& measured,
            const BallArm& arm, const Vec3& tip, bool steady, State& state, Output& output) noexcept {
  Input input = measured;
  input.device_point_base_m = tip;
  Touched touched;
  Vec3 others_N;
  if (!scene.empty()) {
    touched = Touch(scene, bound, input, state, output);
    input.device_point_base_m = tip + arm.to_tip_m;
    input.velocity_base_m_s = measured.velocity_base_m_s + arm.rate_m_s;
    others_N = touched.others_N +
               StepVehicle(config, bound, scene, input, touched.contacts_N + touched.others_N, state, output);
  }
  const bool passive = IsAlone(input, steady, state) && !touched.moving && others_N == Vec3{};
  output.energy_gain = Watch(measured, touched, steady, passive, state);
  const Vec3 wanted_N = output.energy_gain * touched.contacts_N + others_N;
  Limit(config, input, input.tracked ? state.ramp * wanted_N : Vec3{}, state, output);
}

// A far tip should cost nothing: no copies, no queries. `input`: at the centre of a ball.
void StepClean(const Config& config, const Scene& scene, const Input& input, const BallArm& arm, State& state,
               Output& output) noexcept {
  const bool steady = Remember(config, input, state);
  StiffnessBound bound;
  Vec3 tip = input.device_point_base_m;
  if (input.tracked) {
    bound = UpdateStiffnessBound(config, input, AnyContact(state), state.bound);
    tip = tip + bound.predict_s * input.velocity_base_m_s;
  }
  output.stiffness_offered_N_m = bound.along_N_m;
  if (state.last_force_N == Vec3{} && NothingHere(scene, input, tip, state)) {
    output.energy_gain = Watch(input, {}, steady, IsAlone(input, steady, state), state);
  } else {
    Render(config, bound, scene, input, arm, tip, steady, state, output);
  }
  if (!input.tracked) return;
  if (state.ramp < 1) state.ramp = config.ramp_s > 0 ? std::min(1.0, state.ramp + input.dt_s / config.ramp_s) : 1;
  state.was_tracked = true;
  state.appears = false;
  state.last_device_point_base_m = tip;
}

}  // namespace

void EnterScene(const Scene& scene, State& state) noexcept {
  State entered;
  entered.last_force_N = Rotated(state.placement.rotation, state.last_force_N);  // the new scene stands at the origin
  entered.bound = state.bound;
  state = entered;
  if (!scene.empty() && scene.header().has_vehicle != 0) StartCar(scene.header().vehicle, state.vehicle);
}

void Step(const Config& config, const Scene& scene, const Input& input, State& state, Output& output) noexcept {
  Clear(output);
  const BallArm arm = BallArmOf(scene, input);
  const bool clean = IsClean(input), ball = arm.to_tip_m != Vec3{};
  if (clean && !ball) {
    StepClean(config, scene, input, arm, state, output);
  } else {
    StepClean(config, scene, AtCentre(clean ? input : Cleaned(input), arm), arm, state, output);
  }
}

}  // namespace omni::haptics
