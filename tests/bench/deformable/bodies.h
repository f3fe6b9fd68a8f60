// The test bodies: random bodies of revolution, made soft, with their references.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "service/haptics/deformable/build/build_soft_body.h"
#include "tests/bench/deformable/axis_mesh.h"
#include "tests/bench/deformable/axisymmetric.h"

namespace omni::bench {

inline constexpr double kBall_m = 0.005;
inline constexpr double kPoisson = 0.4;

// Radius 14 ... 40 mm, height 12 ... 40 mm, flat, domed or hollow; every seed gives others.
AxisBody DrawBody(std::mt19937_64& rng);

// `count` depths from 0.15 to 1.95 mm, spread evenly in their logarithm and then moved by chance; ascending.
std::vector<double> DrawDepths(std::mt19937_64& rng, int count);

// Where the ball touches: distance from the axis, and the angle around it.
struct Place {
  double aside_m = 0;
  double angle_rad = 0;
};

// Flat until the rim is two balls away; at least a fifth of that off the axis.
Place DrawPlace(const AxisBody& body, std::mt19937_64& rng);

// The reference on two meshes: the finer one's forces, and the change by the last refinement. Quick: one mesh, no
// change.
struct Reference {
  std::vector<double> force_per_modulus_m2;
  std::vector<double> change_pct;
  int nodes = 0;
  bool converged = true;  // Newton, at every depth
};

// On the axis by axisymmetric.h, off the axis by off_axis.h.
Reference MakeReference(const AxisBody& body, double aside_m, const std::vector<double>& depths_m, bool quick);

// Made soft, clamped at z = 0, without relaxation; the grid is shifted by the seed.
haptics::SoftBody MakeSoft(const AxisBody& body, const haptics::ElasticModuli& moduli, const haptics::Vec3& fibre,
                           std::uint32_t tets, std::uint64_t seed, haptics::SoftBuildReport& report);

// Long-term force along the normal.
double ForceAt(const haptics::SoftBody& soft, const AxisBody& body, const Place& place, double depth_m);

double HertzPerModulus(double depth_m);
double PercentOff(double value, double reference);

}  // namespace omni::bench
