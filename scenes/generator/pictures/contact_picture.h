// A contact as the renderer computes it, as meshes to draw: the tip where the device has it, the proxy on the surface,
// the spring between them, the force as an arrow.
#pragma once

#include <string>
#include <vector>

#include "scenes/generator/pictures/picture.h"

namespace omni::scenes {

struct TouchedContact {
  Vec tip_m{0.0}, proxy_m{0.0}, force_N{0.0};
};

// Loads the scene of `path` as the service does and moves the tip in 200 ticks from `from_m` to `tip_m`, then holds it
// there for 300. Throws std::runtime_error when the file does not load or nothing is touched.
TouchedContact Touch(const std::string& path, const Vec& from_m, const Vec& tip_m);

// `arrow_m_per_N`: length of the arrow. The proxy is a bright ball, the tip a dark one, the arrow red.
std::vector<DrawnMesh> DrawContact(const TouchedContact& contact, double arrow_m_per_N);

// The pen with its tip at `tip_m`; `axis`: unit, out of the tip. Casts a shadow.
DrawnMesh DrawPen(const Vec& tip_m, const Vec& axis);

// A force on the tip as a red arrow, seen through everything. Nothing for no force.
std::vector<DrawnMesh> DrawForce(const Vec& tip_m, const Vec& force_N, double arrow_m_per_N);

}  // namespace omni::scenes
