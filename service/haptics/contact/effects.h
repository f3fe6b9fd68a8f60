// Simple force models on top of a contact: texture, vibration, viscosity, magnet, pop-through. docs/theory/haptics.md,
// section 6.
#pragma once

#include "service/base/vec.h"
#include "service/haptics/haptics.h"

namespace omni::haptics {

using base::Vec3;

// A ridge pattern rendered as a ripple of the normal force while the tip slides over it.
struct TextureEffect {
  double amplitude_m, wavelength_m, gain;
  // Advances `phase` (in wavelengths) by the path `slid_m`.
  double ForceOn(double stiffness_N_m, double normal_force_N, double slid_m, double dt_s, double& phase) const noexcept;
};

// A steady hum while touched.
struct VibrationEffect {
  double amplitude_N, frequency_Hz;
  double ForceOn(std::int64_t t_ns, double normal_force_N) const noexcept;
};

// Drag inside the volume.
struct ViscosityEffect {
  double viscosity_Ns_m, limit_Ns_m;
  Vec3 ForceOn(const Vec3& velocity_m_s) const noexcept;
};

// Pulls the tip to the surface from outside; zero at the surface and at `range_m`, strongest half-way.
struct MagnetEffect {
  double max_force_N, range_m;
  double ForceOn(double gap_m, double stiffness_limit_N_m) const noexcept;
};

// The skin gives way above a force.
struct PopThroughEffect {
  double threshold_N;
  bool GivesWay(double normal_force_N) const noexcept { return threshold_N > 0 && normal_force_N > threshold_N; }
};

}  // namespace omni::haptics
