// Seeded worst-case input of a tick: a pen that teleports and vanishes, commands of a hostile application and of a
// stuck control thread, scans that are wrong, late or lost.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

#include "service/base/limits.h"
#include "service/loop/tick.h"
#include "service/sim/fields/vec3.h"
#include "tests/support/rig/rig.h"
#include "tests/support/rig/scan_faults.h"

namespace omni::test {

inline bool OneIn(std::uint64_t n, sim::Random& random) { return random.Bits() % n == 0; }

inline base::Vec3 DrawUnit(sim::Random& random) { return Normalized(random.NormalVector(1)); }

inline double DrawOdd(sim::Random& random) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN(), kInf = std::numeric_limits<double>::infinity();
  constexpr std::array<double, 7> kOdd{kNan, kInf, -kInf, -1e300, 1e30, 1e-310, -1};
  return kOdd[random.Bits() % kOdd.size()];
}

// A pen about the base, up to 1 m/s and 10 rad/s, that never cuts the hull. Now and then it jumps elsewhere, or is
// removed.
class HostilePen {
 public:
  HostilePen(sim::Rig& rig, sim::Random& random) : rig_(rig), random_(random), pose_(rig.DrawPose(kRange, random)) {}

  void Move(double dt_s) {
    ++calm_ticks_;
    if (absent_ticks_ > 0 && --absent_ticks_ > 0) return;
    if (OneIn(1500, random_)) absent_ticks_ = 1 + static_cast<int>(random_.Bits() % 200);
    if (absent_ticks_ > 0 || OneIn(700, random_)) {
      pose_ = rig_.DrawPose(kRange, random_);
      calm_ticks_ = 0;
    }
    if (OneIn(100, random_)) Turn();
    sim::MagnetPose next = pose_;
    next.centre_base_m = pose_.centre_base_m + dt_s * velocity_m_s_;
    next.axis_base = Normalized(sim::Rotated(pose_.axis_base, dt_s * turn_rad_s_));
    const double r = base::Norm(next.centre_base_m);
    const bool fits = r < kRange.radius_max_m && next.centre_base_m.z > 0 &&
                      sim::GapToHull(rig_.device().magnet, rig_.device().hull_radius_m, next).gap_m > 0;
    if (fits) {
      pose_ = next;
    } else {
      Turn();
    }
  }

  const sim::MagnetPose* pose() const { return absent_ticks_ > 0 ? nullptr : &pose_; }
  int calm_ticks() const { return calm_ticks_; }  // since its last jump

 private:
  static constexpr sim::PoseRange kRange{.radius_min_m = 0.0411, .radius_max_m = 0.09, .tilt_max_rad = 1.3};

  void Turn() {
    velocity_m_s_ = random_.Uniform(0, 1) * DrawUnit(random_);
    turn_rad_s_ = random_.Uniform(0, 10) * DrawUnit(random_);
  }

  sim::Rig& rig_;
  sim::Random& random_;
  sim::MagnetPose pose_;
  base::Vec3 velocity_m_s_, turn_rad_s_;
  int absent_ticks_ = 0, calm_ticks_ = 0;
};

// Output of the control thread if applications request everything at once, with numbers that no client should send.
class HostileCommands {
 public:
  explicit HostileCommands(sim::Random& random) : random_(random) {
    now_.gate = loop::ForceGate::kOpen;
    now_.idle = false;
    now_.scene_generation = 1;
    now_.applied.open = true;
    auto& thresholds = now_.inputs.thresholds;
    thresholds.detent_press_N = 0.2;
    thresholds.detent_release_N = 0.1;
    thresholds.detent_pulse_N = 0.5;
  }

  const loop::Commands& Next(std::int64_t t_ns, const base::Vec3& tip_base_m) {
    if (stuck_ticks_ > 0 && --stuck_ticks_ > 0) return now_;
    if (OneIn(800, random_)) stuck_ticks_ = static_cast<int>(random_.Bits() % 300);
    now_.t_ns = t_ns;
    ChangeOwner();
    if (OneIn(60, random_)) Push(t_ns);
    if (OneIn(90, random_)) Constrain(t_ns, tip_base_m);
    if (OneIn(120, random_)) Vibrate();
    if (OneIn(50, random_)) MoveScene(t_ns);
    return now_;
  }

  const loop::VibrationSamples* samples() const { return samples_.get(); }

 private:
  void ChangeOwner() {
    if (OneIn(500, random_)) now_.gate = static_cast<loop::ForceGate>(random_.Bits() % 3);
    if (OneIn(60, random_)) now_.gate = loop::ForceGate::kOpen;
    if (OneIn(900, random_)) now_.scene_generation = 3 - now_.scene_generation;
    if (OneIn(400, random_)) now_.force_scale = OneIn(2, random_) ? DrawOdd(random_) : random_.Uniform(0, 1);
    if (OneIn(60, random_)) now_.force_scale = 1;
  }

  void Push(std::int64_t t_ns) {
    haptics::AppliedCommand& applied = now_.applied;
    applied.open = !OneIn(8, random_);
    ++applied.force_id;
    applied.force_base_N = random_.Uniform(0, 4) * DrawUnit(random_);
    if (OneIn(20, random_)) applied.force_base_N.y = DrawOdd(random_);
    applied.force_end_ns = t_ns + static_cast<std::int64_t>(random_.Uniform(0, 2e8));
    applied.ramp_s = OneIn(2, random_) ? 0 : OneIn(20, random_) ? DrawOdd(random_) : random_.Uniform(0, 0.05);
  }

  void Constrain(std::int64_t t_ns, const base::Vec3& tip_base_m) {
    haptics::AppliedCommand& applied = now_.applied;
    ++applied.constraints_id;
    applied.constraints_t_ns = t_ns;
    applied.constraint_count = static_cast<std::uint32_t>(random_.Bits() % 4);
    for (std::uint32_t i = 0; i < applied.constraint_count; ++i) {
      haptics::Constraint& c = applied.constraints[i];
      c.kind = static_cast<haptics::ConstraintKind>(1 + random_.Bits() % haptics::kConstraintKinds);
      c.side = static_cast<haptics::ConstraintSide>(random_.Bits() % 3);
      c.stiffness_N_m = random_.Uniform(0, 5000);
      c.damping_Ns_m = random_.Uniform(0, 20);
      c.max_force_N = random_.Uniform(0, 5);
      c.radius_m = random_.Uniform(1e-3, 1e-2);
      c.point_base_m = tip_base_m + random_.NormalVector(3e-3);
      c.direction_base = DrawUnit(random_);
      c.velocity_base_m_s = random_.NormalVector(0.05);
      if (OneIn(30, random_)) c.point_base_m.z = DrawOdd(random_);
    }
  }

  void Vibrate() {
    loop::HapticWaveform& wave = now_.haptic;
    ++wave.id;
    wave.active = !OneIn(5, random_);
    wave.kind = static_cast<loop::VibrationKind>(random_.Bits() % 3);
    wave.duration_s = OneIn(20, random_) ? DrawOdd(random_) : random_.Uniform(0, 0.3);
    wave.amplitude = OneIn(20, random_) ? DrawOdd(random_) : 1;
    wave.frequency_Hz = OneIn(20, random_) ? DrawOdd(random_) : random_.Uniform(20, 499);
    samples_->id = wave.id;
    samples_->count = loop::kMaxVibrationSamples;
    for (float& value : samples_->values) value = OneIn(2, random_) ? 1.0F : -1.0F;
  }

  void MoveScene(std::int64_t t_ns) {
    now_.scene.generation = now_.scene_generation;
    loop::PoseSample& pose = now_.scene.placement;
    pose.t_ns = t_ns + static_cast<std::int64_t>(random_.Uniform(-5e7, 1e8));
    ++pose.number;
    pose.leaps = OneIn(5, random_);
    pose.position_m = random_.NormalVector(3e-3);
    pose.velocity_m_s = random_.NormalVector(0.1);
    if (OneIn(20, random_)) pose.position_m.x = DrawOdd(random_);
  }

  sim::Random& random_;
  loop::Commands now_;
  std::unique_ptr<loop::VibrationSamples> samples_ = std::make_unique<loop::VibrationSamples>();
  int stuck_ticks_ = 0;
};

// Faults of service/sim/scan_faults.h, one after another, with pauses.
class HostileScans {
 public:
  HostileScans(sim::Rig& rig, sim::Random& random)
      : rig_(rig), context_{random, {}, {}, {}, 0, sim::NoiseOf_T(sim::NoiseMode::kLowPower)[0]} {
    const base::Vec3 far{0, 0, 0.5};
    other_ = {far, {0, 0, 1}};
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      sim::CoilArray unit{};
      unit[k] = 1;
      coil_map_[k] = rig_.Readings(nullptr, unit);
    }
  }

  void Spoil(base::HallScan& scan) {
    sim::Random& random = context_.random;
    if (--left_ <= 0) Draw(scan);
    if (fault_ == 0) context_.held = scan;
    for (std::size_t i = 0; i < context_.no_pen.size(); ++i) {
      context_.no_pen[i] = {};
      for (std::size_t k = 0; k < base::kCoilCount; ++k) {
        context_.no_pen[i] = context_.no_pen[i] + scan.coil_current_A[k] * coil_map_[k][i];
      }
    }
    sim::ScanFaults()[fault_].apply(context_, scan);
    if (OneIn(50, random)) scan.response_ns = static_cast<std::int64_t>(random.Uniform(0, 2e6));
  }

  bool good() const { return fault_ == 0; }

 private:
  void Draw(const base::HallScan& scan) {
    sim::Random& random = context_.random;
    const bool pause = fault_ != 0;
    fault_ = pause ? 0 : 1 + random.Bits() % (sim::ScanFaults().size() - 1);
    left_ = 1 + static_cast<int>(random.Bits() % (pause ? 400 : 40));
    context_.sensors = 1U + static_cast<std::uint32_t>(random.Bits() % 255);
    context_.held = scan;
    other_.centre_base_m = random.Uniform(0.08, 0.3) * DrawUnit(random);
    context_.other_magnet = rig_.Readings(&other_, {});
  }

  sim::Rig& rig_;
  sim::FaultContext context_;
  sim::MagnetPose other_;
  std::array<sim::SensorFields, base::kCoilCount> coil_map_;
  std::size_t fault_ = 0;
  int left_ = 300;
};

// Milliseconds to the next scan: about one; now and then some are lost, or the device was away.
inline std::int64_t DrawPeriod_ns(sim::Random& random) {
  if (OneIn(2000, random)) return static_cast<std::int64_t>(random.Uniform(1e7, 5e8));
  if (OneIn(50, random)) return base::kTickPeriod_ns * static_cast<std::int64_t>(2 + random.Bits() % 8);
  return static_cast<std::int64_t>(random.Uniform(0.97e6, 1.03e6));
}

}  // namespace omni::test
