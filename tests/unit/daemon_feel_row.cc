// Each field of a material's feel has its own place in the protocol's row, either way.
#include "service/daemon/feel_row.h"

#include <gtest/gtest.h>

#include "service/protocol/haptic_scene_range.h"

namespace omni::daemon {
namespace test_daemon_feel_row {

// No two alike, and all in the protocol's range.
constexpr protocol::HapticFeel kRow{.stiffness_N_m = 321,
                                    .damping_Ns_m = 1.5,
                                    .static_friction = 0.7,
                                    .dynamic_friction = 0.6,
                                    .viscosity_Ns_m = 0.25,
                                    .texture_amplitude_m = 0.0003,
                                    .texture_wavelength_m = 0.002,
                                    .texture_gain = 0.8,
                                    .vibration_amplitude_N = 0.4,
                                    .vibration_frequency_Hz = 150,
                                    .pop_through_N = 1.25};

// The same names in both structures, and in a material.
template <class Feel>
void ExpectIsTheRow(const Feel& feel) {
  EXPECT_EQ(feel.stiffness_N_m, kRow.stiffness_N_m);
  EXPECT_EQ(feel.damping_Ns_m, kRow.damping_Ns_m);
  EXPECT_EQ(feel.static_friction, kRow.static_friction);
  EXPECT_EQ(feel.dynamic_friction, kRow.dynamic_friction);
  EXPECT_EQ(feel.viscosity_Ns_m, kRow.viscosity_Ns_m);
  EXPECT_EQ(feel.texture_amplitude_m, kRow.texture_amplitude_m);
  EXPECT_EQ(feel.texture_wavelength_m, kRow.texture_wavelength_m);
  EXPECT_EQ(feel.texture_gain, kRow.texture_gain);
  EXPECT_EQ(feel.vibration_amplitude_N, kRow.vibration_amplitude_N);
  EXPECT_EQ(feel.vibration_frequency_Hz, kRow.vibration_frequency_Hz);
  EXPECT_EQ(feel.pop_through_N, kRow.pop_through_N);
}

TEST(DaemonFeelRow, EveryFieldComesAcrossBothWays) {
  ExpectIsTheRow(FeelOf(kRow));
  haptics::Material material;
  material.stiffness_N_m = kRow.stiffness_N_m;
  material.damping_Ns_m = kRow.damping_Ns_m;
  material.static_friction = kRow.static_friction;
  material.dynamic_friction = kRow.dynamic_friction;
  material.viscosity_Ns_m = kRow.viscosity_Ns_m;
  material.texture_amplitude_m = kRow.texture_amplitude_m;
  material.texture_wavelength_m = kRow.texture_wavelength_m;
  material.texture_gain = kRow.texture_gain;
  material.vibration_amplitude_N = kRow.vibration_amplitude_N;
  material.vibration_frequency_Hz = kRow.vibration_frequency_Hz;
  material.pop_through_N = kRow.pop_through_N;
  ExpectIsTheRow(FeelRow(material));
}

TEST(DaemonFeelRow, BeyondTheProtocolsRangeIsItsLimit) {
  haptics::Material material;
  material.stiffness_N_m = 1e9;
  EXPECT_EQ(FeelRow(material).stiffness_N_m, protocol::Tamed({.stiffness_N_m = 1e9}).stiffness_N_m);
  EXPECT_LT(FeelRow(material).stiffness_N_m, 1e9);
}

}  // namespace test_daemon_feel_row
}  // namespace omni::daemon
