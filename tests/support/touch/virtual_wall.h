// A simulated hand that presses a pen against a flat wall: mass, damping and stiffness of a hand, a tracker's noise and
// filter, the whole delay, the coil's lag, and haptics::Step in between. One dimension moves; the truth is integrated
// in fiftieths of a tick. The reference for stability: it shares no formula with the rule it checks.
#pragma once

#include <cstdint>
#include <vector>

#include "service/haptics/haptics.h"
#include "service/haptics/scene/material.h"
#include "service/haptics/scene/scene.h"
#include "service/sim/fields/tremor.h"

namespace omni::test {

struct WallHand {
  double mass_kg = 0.12;
  double damping_Ns_m = 1;
  double stiffness_N_m = 150;
};

struct WallLoop {
  double delay_s = 0;          // sample to control step, as given to haptics
  double late_s = 0;           // true additional delay
  double coil_lag_s = 0.3e-3;  // of the closed current loop
  double noise_m = 0;          // white, of every sample and axis
};

enum class WallRule {
  kFixed,    // the wall has the given stiffness
  kBounded,  // as haptics allows, given the delay and the filter's covariance
};

struct WallRun {
  double stiffness_N_m = 0;  // fixed, or as allowed in the end
  double predict_s = 0;
  std::vector<double> measured_m, force_N;  // once a tick
  double given_J = 0;                       // integral of F v dt
  double least_gain = 1;                    // left by a watch
  std::vector<double> gain;                 // the same, once a tick
};

// Outside for 0.3 s, in within 0.5 s until the hand's rest position is `depth_m` deep, `hold_s` there and, with
// `release`, out again and at rest. `stiffness_N_m`: of the wall's material; 0: no wall.
struct WallScenario {
  double depth_m = 5e-3;
  double hold_s = 6;
  bool release = false;
  // Motion of the hand's own on top of it: a rhythm while it holds, and a tremor along the wall's normal throughout.
  double press_m = 0, press_Hz = 0;
  double tremor_m = 0;  // rms
  sim::TremorBand tremor;
};

WallRun PressWall(const WallHand& hand, const WallLoop& loop, const WallScenario& scenario, WallRule rule,
                  double stiffness_N_m, std::uint64_t seed);

// A slab of that material whose upper face is z = `top_m`.
haptics::Scene Wall(double top_m, const haptics::Material& material);

// The same with ridges along y on it: a triangle wave of that pitch and height below `top_m`.
haptics::Scene Ridges(double top_m, double pitch_m, double height_m, const haptics::Material& material);

// rms of x above `from_Hz`, once per tick, in the second half of [from, to).
double RmsAbove(const std::vector<double>& x, std::size_t from, std::size_t to, double from_Hz);

// Root mean square of x about its mean over [from, to).
double RmsAboutMean(const std::vector<double>& x, std::size_t from, std::size_t to);
// The same without a steady drift.
double RmsAboutLine(const std::vector<double>& x, std::size_t from, std::size_t to);

}  // namespace omni::test
