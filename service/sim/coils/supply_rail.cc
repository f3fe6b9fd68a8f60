#include "service/sim/coils/supply_rail.h"

#include <algorithm>
#include <cmath>

namespace omni::sim {

void SupplyRail::Step(double load_A, double dt_s) noexcept {
  const double draw_A = load_A + parameters_.quiescent_A;
  double left_s = dt_s;
  if (draw_A < 0) rail_V_ = std::max(rail_V_, source_V_);
  if (rail_V_ > source_V_ || draw_A < 0) {
    // The diode blocks until the load has pulled the rail down to the source.
    const double change_V = -draw_A * left_s / parameters_.capacitance_F;
    const bool reaches_source = rail_V_ + change_V < source_V_;
    left_s = reaches_source ? left_s - (rail_V_ - source_V_) * parameters_.capacitance_F / draw_A : 0;
    rail_V_ = reaches_source ? source_V_ : rail_V_ + change_V;
  }
  const double settled_V = source_V_ - parameters_.source_ohm * draw_A;
  const double decay = std::exp(-left_s / (parameters_.source_ohm * parameters_.capacitance_F));
  rail_V_ = std::clamp(settled_V + (rail_V_ - settled_V) * decay, 0.0, parameters_.clamp_V);
}

}  // namespace omni::sim
