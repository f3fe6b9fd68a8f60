#include "service/haptics/contact/effects.h"

#include <numbers>

namespace omni::haptics {
namespace {

constexpr double kTextureForce_N = 0.1;
constexpr double kTextureFade_Hz = 100;  // full below; nothing above kTextureStop_Hz, where the coil cannot follow
constexpr double kTextureStop_Hz = 150;

double SinTurns(double turns) noexcept { return std::sin(2 * std::numbers::pi * turns); }

}  // namespace

// F = gain K a sin(2 pi s / lambda), at most 0.1 N and half the normal force   (6.1)
double TextureEffect::ForceOn(double stiffness_N_m, double normal_force_N, double slid_m, double dt_s,
                              double& phase) const noexcept {
  if (!(amplitude_m > 0 && gain > 0 && wavelength_m > 0 && dt_s > 0)) return 0;
  const double turns = slid_m / wavelength_m;
  phase = std::fmod(phase + turns, 1.0);
  const double frequency_Hz = turns / dt_s;
  const double fade = std::clamp((kTextureStop_Hz - frequency_Hz) / (kTextureStop_Hz - kTextureFade_Hz), 0.0, 1.0);
  const double amplitude_N = std::min({gain * stiffness_N_m * amplitude_m, kTextureForce_N, 0.5 * normal_force_N});
  return fade * amplitude_N * SinTurns(phase);
}

// F = min(A, F_n) sin(2 pi f t)   (6.2): never lifts off.
double VibrationEffect::ForceOn(std::int64_t t_ns, double normal_force_N) const noexcept {
  if (!(amplitude_N > 0 && frequency_Hz > 0)) return 0;
  const double turns = std::fmod(1e-9 * static_cast<double>(t_ns) * frequency_Hz, 1.0);
  return std::min(amplitude_N, normal_force_N) * SinTurns(turns);
}

Vec3 ViscosityEffect::ForceOn(const Vec3& velocity_m_s) const noexcept {
  return -std::clamp(viscosity_Ns_m, 0.0, limit_Ns_m) * velocity_m_s;
}

// F = 4 F_max x (1 - x), x = gap / range; steepest slope 4 F_max / range stays within the stiffness limit   (6.3)
double MagnetEffect::ForceOn(double gap_m, double stiffness_limit_N_m) const noexcept {
  if (!(gap_m > 0 && gap_m < range_m)) return 0;
  const double peak_N = std::min(max_force_N, 0.25 * stiffness_limit_N_m * range_m);
  const double x = gap_m / range_m;
  return 4 * peak_N * x * (1 - x);
}

}  // namespace omni::haptics
