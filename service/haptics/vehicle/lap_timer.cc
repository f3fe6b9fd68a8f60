#include "service/haptics/vehicle/car_motion.h"

namespace omni::haptics {
namespace {

struct Crossing {
  int direction = 0;  // +1 ahead, -1 back, 0 none
  double share = 0;   // of the way from `before` to `after`
};

// A point on the line itself still counts as before it, so that every crossing is seen once.
Crossing Cross(const Checkpoint& line, const Vec3& before, const Vec3& after) noexcept {
  // The middle of the line is within half its width of the crossing.
  const Vec3 away = before - line.position_base_m, way = after - before;
  const double reach_m = 0.5 * line.width_m + std::abs(way.x) + std::abs(way.y);
  if (away.x * away.x + away.y * away.y > reach_m * reach_m) return {};
  const Vec3 ahead{std::cos(line.heading_rad), std::sin(line.heading_rad), 0};
  const double from = Dot(before - line.position_base_m, ahead), to = Dot(after - line.position_base_m, ahead);
  if ((from > 0) == (to > 0)) return {};
  const double share = from / (from - to);
  const Vec3 off = before + share * (after - before) - line.position_base_m;
  if (!(std::abs(ahead.x * off.y - ahead.y * off.x) <= 0.5 * line.width_m)) return {};
  return {to > 0 ? 1 : -1, share};
}

Checkpoint StartLine(const VehicleInput& car) noexcept {
  const Vec3 ahead{std::cos(car.start_heading_rad), std::sin(car.start_heading_rad), 0};
  return {car.start_base_m + car.start_line_m * ahead, car.start_heading_rad, car.line_width_m};
}

// `late_s`: time of the tick after the crossing.
void PassStart(const VehicleInput& car, bool ahead, double late_s, LapState& lap) noexcept {
  if (!ahead) {
    if (lap.owed < 1'000'000) ++lap.owed;
    return;
  }
  if (lap.owed > 0) {
    --lap.owed;
    return;
  }
  if (lap.running && lap.next != static_cast<std::uint32_t>(car.checkpoint_count)) return;  // one is missing
  if (lap.running) {
    lap.laps += 1;
    lap.last_s = lap.time_s - late_s;
    lap.best_s = lap.best_s > 0 ? std::min(lap.best_s, lap.last_s) : lap.last_s;
  }
  lap.running = true;
  lap.next = 0;
  lap.time_s = late_s;
}

}  // namespace

void AdvanceLap(const VehicleInput& car, const Vec3& before, const Vec3& after, double dt_s, LapState& lap) noexcept {
  if (lap.running) lap.time_s += dt_s;
  if (before == after) return;
  const Crossing start = Cross(StartLine(car), before, after);
  // At most one line is due either way, so their order within a tick does not matter.
  const auto count = static_cast<std::uint32_t>(car.checkpoint_count);
  if (lap.running && lap.owed == 0) {
    if (lap.next < count && Cross(car.checkpoints[lap.next], before, after).direction > 0) {
      ++lap.next;
    } else if (lap.next > 0 && Cross(car.checkpoints[lap.next - 1], before, after).direction < 0) {
      --lap.next;
    }
  }
  if (start.direction != 0) PassStart(car, start.direction > 0, (1 - start.share) * dt_s, lap);
}

}  // namespace omni::haptics
