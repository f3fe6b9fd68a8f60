#include "service/calibration/checks/coverage.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace omni::calibration {

// Bands of equal height on a sphere have equal area [Archimedes].
void Coverage::Add(const base::Vec3& position_base_m) noexcept {
  const base::Vec3& p = position_base_m;
  const double height = p.z / Norm(p);
  if (!(height >= 0)) return;
  const double turn = std::atan2(p.y, p.x) / (2 * std::numbers::pi);
  const int band = std::min(kCoverageBands - 1, static_cast<int>(height * kCoverageBands));
  const int sector = std::min(kCoverageSectors - 1, static_cast<int>((turn < 0 ? turn + 1 : turn) * kCoverageSectors));
  ++visits[static_cast<std::size_t>(band) * kCoverageSectors + static_cast<std::size_t>(sector)];
}

double Coverage::share() const noexcept {
  const auto visited = std::count_if(visits.begin(), visits.end(), [](int count) { return count > 0; });
  return static_cast<double>(visited) / kCoverageCells;
}

}  // namespace omni::calibration
