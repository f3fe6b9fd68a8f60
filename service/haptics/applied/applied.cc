#include "service/haptics/applied/applied.h"

#include "service/base/clock.h"
#include "service/base/limits.h"
#include "service/base/vec.h"
#include "service/haptics/stability/contact_watch.h"

namespace omni::haptics {

using base::Vec3;
namespace {

constexpr double kCalm_N = 0.020;        // of the damping force that velocity noise causes, 1 sigma
constexpr double kContactLeaves = 0.25;  // of the bound, whatever contacts use: half of the gain margin of (3.2)
constexpr double kLimitedFrom = 0.98;    // rendered over requested stiffness below which a constraint is limited
constexpr double kFarthest_m = 100, kFastest_m_s = 1e3;

// Fades advance even while a device's timestamps stand still.
double FadeStep_s(double dt_s) noexcept { return dt_s > 0 ? std::min(dt_s, 5e-3) : base::kTickPeriod_s; }

double Approach(double from, double to, double dt_s, double time_s) noexcept {
  return from + (to - from) * std::min(1.0, dt_s / time_s);
}

double Follow(const AppliedConfig& config, double from, double to, double dt_s) noexcept {
  return Approach(from, to, dt_s, to < from ? config.follow_fall_s : config.follow_rise_s);
}

Vec3 DirectForce(const AppliedState& state) noexcept {
  const double share = state.move_s > 0 ? std::min(1.0, state.moved_s / state.move_s) : 1.0;
  return (1 - share) * state.from_N + share * state.to_N;
}

void MoveForce(AppliedState& state, const Vec3& to_N, double over_s) noexcept {
  state.from_N = DirectForce(state);
  state.to_N = to_N;
  state.moved_s = 0;
  state.move_s = over_s;
}

// The application's force: started, ramped, and faded out when it expires.
Vec3 StepForce(const AppliedConfig& config, const AppliedCommand& command, const AppliedInput& input,
               AppliedState& state) noexcept {
  const bool due = command.open && input.allowed && base::StampDifference_ns(command.force_end_ns, input.t_ns) > 0;
  if (command.force_id != state.force_id) {
    state.force_id = command.force_id;
    const bool usable = due && IsWithin(command.force_base_N, 1e6) && command.ramp_s >= 0;
    MoveForce(state, usable ? command.force_base_N : Vec3{}, usable ? command.ramp_s : config.close_s);
  }
  if (!due && state.to_N != Vec3{}) MoveForce(state, {}, config.close_s);
  state.moved_s = std::min(state.moved_s + FadeStep_s(input.dt_s), 1.0);
  if (state.moved_s >= state.move_s) state.from_N = state.to_N;
  return DirectForce(state);
}

// One spring of this tick.
struct Spring {
  Constraint shape;
  Stretch stretch;
  double stiffness_N_m = 0;  // before the share
  double load = 0;           // over the stiffness bound in its direction
};

struct Springs {
  std::array<Spring, kMaxConstraints> of;
  std::uint32_t count = 0;
};

double BoundTo(const StiffnessBound& given, const Spring& spring) noexcept {
  const bool one_direction = spring.stretch.stiff.shape == Subspace::Shape::kAlong;
  return one_direction ? StiffnessAlong(given, spring.stretch.outward) : given.stiffness_N_m;
}

Springs ConstraintSprings(const AppliedCommand& command, const AppliedInput& input,
                          const StiffnessBound& given) noexcept {
  Springs springs;
  const double after_s = base::Elapsed_s(input.t_ns, command.constraints_t_ns);
  springs.count = std::min(command.constraint_count, kMaxConstraints);
  const Vec3 tip = input.device_point_base_m + given.predict_s * input.velocity_base_m_s;
  for (std::uint32_t i = 0; i < springs.count; ++i) {
    Spring& spring = springs.of[i];
    spring.shape = MovedConstraint(command.constraints[i], after_s);
    spring.stretch = StretchOf(spring.shape, tip);
    const double bound_N_m = BoundTo(given, spring);
    const double asked_N_m = std::max(0.0, spring.shape.stiffness_N_m);
    spring.stiffness_N_m = std::min(asked_N_m, std::max(0.0, bound_N_m));
    const bool acts = spring.stretch.length_m > 0 && spring.stiffness_N_m > 0;
    spring.load = acts ? spring.stiffness_N_m / bound_N_m : 0;
  }
  return springs;
}

// Springs that act at once add up: each is scaled so that no direction exceeds its stiffness bound after contacts have
// taken their share.   (14.6)
double ShareOf(const Springs& springs, const Output* contacts) noexcept {
  double share = 1;
  for (std::uint32_t i = 0; i < springs.count; ++i) {
    const Spring& a = springs.of[i];
    if (!(a.load > 0)) continue;
    double own = 0, taken = 0;
    for (std::uint32_t j = 0; j < springs.count; ++j) {
      const Spring& b = springs.of[j];
      if (b.load > 0) own += b.load * (i == j ? 1 : Overlap(a.stretch.stiff, b.stretch.stiff));
    }
    const int touched = contacts == nullptr ? 0 : std::clamp(contacts->contact_count, 0, kMaxContacts);
    for (int k = 0; k < touched; ++k) {
      const Contact& contact = contacts->contacts[static_cast<std::size_t>(k)];
      taken += contact.load * Overlap(a.stretch.stiff, {Subspace::Shape::kAlong, contact.normal_base});
    }
    const double room = std::max(kContactLeaves, 1 - taken);
    if (own > room) share = std::min(share, room / own);
  }
  return share;
}

double DampingShare(const Springs& springs, double given_Ns_m) noexcept {
  double sum_Ns_m = 0;
  for (std::uint32_t i = 0; i < springs.count; ++i) sum_Ns_m += std::max(0.0, springs.of[i].shape.damping_Ns_m);
  return sum_Ns_m > given_Ns_m ? given_Ns_m / sum_Ns_m : 1;
}

// Stiffness and damping allowed for constraints, changed too slowly for the hand to notice.
StiffnessBound UpdateGiven(const AppliedConfig& config, const AppliedInput& input, AppliedState& state) noexcept {
  const double noise_Ns_m = input.velocity_sigma_m_s > 0 ? kCalm_N / input.velocity_sigma_m_s : 1e6;
  const double damping_Ns_m = std::min(input.bound.damping_Ns_m, noise_Ns_m);
  const double stiffness_N_m = std::max(0.0, input.bound.stiffness_N_m);
  const double along_N_m = std::max(stiffness_N_m, input.bound.along_N_m);
  const double dt_s = FadeStep_s(input.dt_s);
  if (!state.known) {
    state.known = true;
    state.stiffness_N_m = stiffness_N_m;
    state.along_N_m = along_N_m;
    state.damping_Ns_m = damping_Ns_m;
  }
  state.stiffness_N_m = Follow(config, state.stiffness_N_m, stiffness_N_m, dt_s);
  state.along_N_m = Follow(config, state.along_N_m, along_N_m, dt_s);
  state.damping_Ns_m = Follow(config, state.damping_Ns_m, damping_Ns_m, dt_s);
  StiffnessBound given = input.bound;
  given.stiffness_N_m = state.stiffness_N_m;
  given.along_N_m = state.along_N_m;
  given.damping_Ns_m = state.damping_Ns_m;
  return given;
}

struct Rendered {
  Vec3 force_N;
  double stored_J = 0;
  double stiffness_N_m = 0;  // of the stiffest spring that acts
  bool conservative = true;
};

Rendered Sum(const Springs& springs, const AppliedInput& input, const StiffnessBound& given, double share,
             AppliedOutput& output) noexcept {
  Rendered all;
  const double damping_share = DampingShare(springs, given.damping_Ns_m);
  const Vec3 tip = input.device_point_base_m + given.predict_s * input.velocity_base_m_s;
  for (std::uint32_t i = 0; i < springs.count; ++i) {
    const Spring& spring = springs.of[i];
    const double stiffness_N_m = share * spring.stiffness_N_m;
    const double damping_Ns_m = damping_share * std::max(0.0, spring.shape.damping_Ns_m);
    const Vec3 force_N =
        ForceOf(spring.shape, spring.stretch, stiffness_N_m, damping_Ns_m, tip, input.velocity_base_m_s);
    if (!IsWithin(force_N, 1e6)) continue;
    all.force_N = all.force_N + force_N;
    all.stored_J += StoredIn_J(spring.shape, spring.stretch, stiffness_N_m);
    if (spring.load > 0) all.stiffness_N_m = std::max(all.stiffness_N_m, stiffness_N_m);
    const bool stands = spring.shape.velocity_base_m_s == Vec3{} && spring.shape.angular_velocity_base_rad_s == Vec3{};
    all.conservative = all.conservative && spring.stretch.conservative && stands;
    const bool softer = spring.load > 0 && stiffness_N_m < kLimitedFrom * spring.shape.stiffness_N_m;
    output.stiffness_limited = output.stiffness_limited || softer || damping_share < kLimitedFrom;
  }
  return all;
}

// All constraints, blended from the previous set without a kick.
Rendered StepConstraints(const AppliedConfig& config, const AppliedCommand& command, const AppliedInput& input,
                         AppliedState& state, AppliedOutput& output) noexcept {
  const bool changed = command.constraints_id != state.constraints_id;
  state.constraints_id = command.constraints_id;
  Rendered now;
  if (command.constraint_count > 0 && input.tracked) {
    const StiffnessBound given = UpdateGiven(config, input, state);
    const Springs springs = ConstraintSprings(command, input, given);
    const double dt_s = FadeStep_s(input.dt_s);
    state.share = Follow(config, state.share, ShareOf(springs, input.contacts), dt_s);
    now = Sum(springs, input, given, state.share, output);
  } else if (command.constraint_count == 0) {
    state.known = false;
    state.share = 1;
  }
  if (changed && state.presence > 0) {
    state.offset_N = state.constraints_N - now.force_N;
    state.offset_left_s = config.blend_s;
  }
  if (state.offset_left_s > 0) {
    now.force_N = now.force_N + (state.offset_left_s / config.blend_s) * state.offset_N;
    now.conservative = false;
    state.offset_left_s = std::max(0.0, state.offset_left_s - FadeStep_s(input.dt_s));
  }
  state.constraints_N = now.force_N;
  return now;
}

// Opens over one time, closes over another.
void MoveGain(bool open, double dt_s, double open_s, double close_s, double& gain) noexcept {
  const double step_s = FadeStep_s(dt_s);
  gain = open ? std::min(1.0, gain + step_s / open_s) : std::max(0.0, gain - step_s / close_s);
}

// The force limit, then the slew limit.
Vec3 Limited(const AppliedConfig& config, const Vec3& wanted_N, double dt_s, const Vec3& last_N) noexcept {
  const double size_N = Norm(wanted_N);
  if (!(size_N < 1e9)) return {};
  const Vec3 target_N = size_N > config.force_max_N ? (config.force_max_N / size_N) * wanted_N : wanted_N;
  const Vec3 change_N = target_N - last_N;
  const double most_N = config.force_slew_N_s * FadeStep_s(dt_s), change = Norm(change_N);
  return change > most_N ? last_N + (most_N / change) * change_N : target_N;
}

bool Usable(const AppliedInput& input) noexcept {
  return input.tracked && IsWithin(input.device_point_base_m, kFarthest_m) &&
         IsWithin(input.velocity_base_m_s, kFastest_m_s);
}

}  // namespace

bool IsAtRest(const AppliedCommand& command, const AppliedState& state) noexcept {
  const bool nothing_new = command.force_id == state.force_id && command.constraint_count == 0;
  if (state.from_N != Vec3{} || state.to_N != Vec3{}) return false;  // set or fading, even while not tracked
  return state.last_N == Vec3{} && state.presence == 0 && state.force_presence == 0 && (!command.open || nothing_new);
}

void ComputeAppliedForce(const AppliedConfig& config, const AppliedCommand& command, const AppliedInput& measured,
                         AppliedState& state, AppliedOutput& output) noexcept {
  output = AppliedOutput{};
  AppliedInput input = measured;
  input.tracked = Usable(measured);
  if (!input.tracked) input.device_point_base_m = input.velocity_base_m_s = {};
  const Vec3 force_N = StepForce(config, command, input, state);
  const Rendered constraints = StepConstraints(config, command, input, state, output);
  const bool open = command.open && input.allowed;
  const bool constrained = open && command.constraint_count > 0;
  output.acts = constrained || force_N != Vec3{};
  MoveGain(constrained && input.tracked, input.dt_s, config.open_s, config.close_s, state.presence);
  MoveGain(force_N != Vec3{} && input.tracked, input.dt_s, config.force_open_s, config.close_s, state.force_presence);
  const bool passive = state.presence == 1 && constraints.conservative && input.dt_s > 0;
  const bool alone = force_N == Vec3{} && (input.contacts == nullptr || input.contacts->force_base_N == Vec3{});
  output.energy_gain = WatchContacts({.tip = input.device_point_base_m,
                                      .velocity_m_s = input.velocity_base_m_s,
                                      .dt_s = input.dt_s,
                                      .noise_m = input.tip_sigma_m,
                                      .velocity_noise_m_s = input.velocity_sigma_m_s,
                                      .force_N = constraints.force_N,
                                      .stiffness_N_m = constraints.stiffness_N_m,
                                      .stored_J = input.acting.share * constraints.stored_J,
                                      .acting = input.acting,
                                      .judged = passive && force_N == Vec3{},
                                      .passive = passive && alone},
                                     state.swing, state.energy);
  const Vec3 held_N = output.energy_gain * constraints.force_N;
  const Vec3 wanted_N = state.force_presence * force_N + state.presence * held_N;
  output.saturated = Norm(wanted_N) > config.force_max_N;
  output.force_base_N = Limited(config, wanted_N, input.dt_s, state.last_N);
  state.last_N = output.force_base_N;
}

}  // namespace omni::haptics
