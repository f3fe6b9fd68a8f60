#include "service/room/sensor_watch.h"

#include <algorithm>
#include <string>
#include <utility>

#include "service/base/vec.h"

namespace omni::room {
namespace {

// "sensor 3", "sensors 0, 1 and 4"
std::string SensorsText(const std::vector<int>& sensors) {
  std::string text = sensors.size() == 1 ? "sensor " : "sensors ";
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    if (i > 0) text += i + 1 == sensors.size() ? " and " : ", ";
    text += std::to_string(sensors[i]);
  }
  return text;
}

constexpr const char* kCheckCable = "check its cable and address, then: omni device selftest";

RoomFinding Silent(std::vector<int> sensors, bool too_few) {
  std::string what = SensorsText(sensors) + (sensors.size() == 1 ? " gives" : " give") + " nothing";
  if (too_few) what += ", and the others are too few for a pose: there is no force";
  return {.kind = "sensor-silent", .sensors = std::move(sensors), .what = std::move(what), .fix = kCheckCable};
}

RoomFinding Stuck(std::vector<int> sensors) {
  const bool one = sensors.size() == 1;
  std::string what = SensorsText(sensors) + (one ? " repeats itself" : " repeat themselves") + ": nothing is measured";
  return {.kind = "sensor-repeats", .sensors = std::move(sensors), .what = std::move(what), .fix = kCheckCable};
}

RoomFinding Wrong(int sensor, bool everywhere) {
  const std::string name = "sensor " + std::to_string(sensor);
  if (everywhere) {
    return {.kind = "sensor-wrong",
            .sensors = {sensor},
            .what = name + " reads wrong and is left out, wherever the pen is",
            .fix = "check its cable and its place, then measure the base again: omni calibrate --replace"};
  }
  return {.kind = "sensor-doubtful",
          .sensors = {sensor},
          .what = name + ", or a magnet near it: it contradicts the others and is left out",
          .fix = "take magnets and steel away from that side of the base; move the pen about to find out which it is"};
}

RoomFinding Frozen() {
  return {.kind = "readings-frozen",
          .sensors = {},
          .what = "every sensor repeats itself while the base's clock goes on: there is no pose and no force",
          .fix = "unplug the base and plug it in again; if it stays: omni device selftest"};
}

}  // namespace

void SensorWatch::Add(const tracker::RoomSample& sample) {
  const base::HallScan& scan = sample.scan;
  const bool tracked = sample.tool.status == base::TrackingStatus::kTracking;
  const bool frozen = (sample.tool.limits & base::kToolFrozen) != 0;
  ++samples_;
  tracked_ += tracked ? 1 : 0;
  frozen_ += frozen ? 1 : 0;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    Sensor& sensor = sensors_[i];
    const bool silent = base::IsSilentSensor(scan, i);
    sensor.silent += silent ? 1 : 0;
    sensor.repeats += !silent && !frozen && scan.field_sensor_T[i] == sensor.last_T ? 1 : 0;
    sensor.last_T = scan.field_sensor_T[i];
    if (!tracked || ((sample.tool.sensors_disagree >> i) & 1u) == 0) continue;
    ++sensor.wrong;
    AddPlace(sample.tool, sensor);
  }
}

void SensorWatch::AddPlace(const base::ToolState& tool, Sensor& sensor) const {
  auto& places = sensor.places_base_m;
  const base::Vec3& here = tool.position_base_m;
  const auto near = [&](const base::Vec3& place) { return base::Distance(place, here) < kPlace_m; };
  if (places.size() < kPlaces && std::none_of(places.begin(), places.end(), near)) places.push_back(here);
}

void SensorWatch::EndSecond() {
  is_frozen_.Add(IsMostly(frozen_, samples_));
  for (Sensor& sensor : sensors_) {
    sensor.is_silent.Add(sensor.silent == samples_);
    sensor.is_stuck.Add(IsMostly(sensor.repeats, samples_));
    const bool known = tracked_ >= (samples_ + 1) / 2;
    sensor.is_wrong.Add(known ? std::optional(IsMostly(sensor.wrong, tracked_)) : std::nullopt);
    if (known && sensor.wrong == 0) sensor.places_base_m.clear();
    sensor.silent = sensor.repeats = sensor.wrong = 0;
  }
  samples_ = tracked_ = frozen_ = 0;
}

void SensorWatch::Report(bool magnet_near, std::vector<RoomFinding>& findings) const {
  if (is_frozen_.holds()) findings.push_back(Frozen());
  std::vector<int> silent, stuck;
  for (int i = 0; i < base::kSensorCount; ++i) {
    const Sensor& sensor = sensors_[static_cast<std::size_t>(i)];
    const bool everywhere = sensor.places_base_m.size() >= kPlaces;
    if (sensor.is_silent.holds()) {
      silent.push_back(i);
    } else if (sensor.is_stuck.holds()) {
      stuck.push_back(i);
    } else if (sensor.is_wrong.holds() && (everywhere || !magnet_near)) {
      findings.push_back(Wrong(i, everywhere));
    }
  }
  if (!silent.empty()) findings.push_back(Silent(silent, too_few()));
  if (!stuck.empty()) findings.push_back(Stuck(stuck));
}

std::uint32_t SensorWatch::useless() const noexcept {
  std::uint32_t mask = 0;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    if (sensors_[i].is_silent.holds() || sensors_[i].is_stuck.holds()) mask |= 1u << i;
  }
  return mask;
}

bool SensorWatch::too_few() const noexcept { return base::kSensorCount - __builtin_popcount(useless()) < kSensorsMin; }

}  // namespace omni::room
