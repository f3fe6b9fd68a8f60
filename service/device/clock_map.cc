#include "service/device/clock_map.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace omni::device {
namespace {

constexpr std::uint64_t kDeviceTimeMax_us = std::uint64_t{1} << 53;  // 285 years; in ns it still fits 63 bits
constexpr std::int64_t kAckAgeMax_us = 50'000;                       // 100 ppm of that: 5 us
constexpr double kRoundTripMin_ns = -2'000;                          // stamps of whole microseconds
constexpr double kRoundTripMax_ns = 100'000'000;
constexpr double kLeap_ns = 1'000'000;
constexpr double kWindow_s = 30;
constexpr double kNoise_ns = 10'000;           // of a sample with the least round trip, and
constexpr double kHiddenShare = 0.05;          // of that: even the least one of a busy link includes queueing
constexpr double kDriftUsual_ns_per_s = 50e3;  // crystals; prior of the slope until samples determine it
constexpr double kDriftMax_ns_per_s = 200e3;

std::int64_t Nanoseconds(std::uint64_t device_us) noexcept { return static_cast<std::int64_t>(device_us) * 1000; }

}  // namespace

std::int64_t ClockMap::Add(const ClockReading& reading) noexcept {
  if (!(reading.t_device_us <= kDeviceTimeMax_us && reading.received_ns >= 0)) {
    ++refused_;
    return GiveOut(reading.received_ns, false);
  }
  const bool back = begun_ && reading.t_device_us < newest_device_us_;
  const bool newer = !begun_ || back || reading.t_device_us > newest_device_us_;
  if (back) ++restarts_;
  if (!begun_ || back) Begin(reading);
  newest_device_us_ = reading.t_device_us;
  TakeArrival(reading);
  const bool agrees = TakeAcknowledgement(reading);
  const double early_ns = static_cast<double>(HostTime_ns(reading.t_device_us) - reading.received_ns);
  if (!agrees || early_ns > round_trip_us() * 1e3 + kLeap_ns) {
    ++restarts_;
    Begin(reading);
    TakeAcknowledgement(reading);
  }
  return GiveOut(std::min(HostTime_ns(reading.t_device_us), reading.received_ns), newer);
}

std::int64_t ClockMap::HostTime_ns(std::uint64_t t_device_us) const noexcept {
  if (!begun_ || t_device_us > kDeviceTimeMax_us) return 0;
  return Nanoseconds(t_device_us) + reference_offset_ns_ + std::llround(Offset_ns(Elapsed_s(t_device_us)));
}

void ClockMap::Restart() noexcept { begun_ = has_best_ = false; }

double ClockMap::drift_ppm() const noexcept { return begun_ ? line_.slope_ns_per_s * 1e-3 : 0; }

double ClockMap::round_trip_us() const noexcept {
  double least_ns = std::numeric_limits<double>::infinity();
  VisitWindow([&](const Sample& sample) { least_ns = std::min(least_ns, sample.round_trip_ns); });
  return has_best_ ? least_ns * 1e-3 : 0;
}

void ClockMap::Begin(const ClockReading& reading) noexcept {
  begun_ = true;
  has_best_ = false;
  kept_count_ = kept_next_ = 0;
  reference_device_us_ = reading.t_device_us;
  reference_offset_ns_ = reading.received_ns - Nanoseconds(reading.t_device_us);
  line_ = {};
}

// The least of (arrival - stamp), allowed to rise as fast as a clock can drift so that it follows the drift.
void ClockMap::TakeArrival(const ClockReading& reading) noexcept {
  if (has_best_) return;
  const double t_s = Elapsed_s(reading.t_device_us);
  const auto arrival_ns =
      static_cast<double>(reading.received_ns - Nanoseconds(reading.t_device_us) - reference_offset_ns_);
  const double risen_ns = line_.offset_ns + kDriftMax_ns_per_s * (t_s - line_.centre_s);
  line_ = {.centre_s = t_s, .offset_ns = std::min(arrival_ns, risen_ns)};
}

// False: the sample contradicts the map.
bool ClockMap::TakeAcknowledgement(const ClockReading& reading) noexcept {
  Sample sample;
  if (!FromAcknowledgement(reading, sample)) return true;
  if (has_best_ && std::abs(sample.offset_ns - Offset_ns(sample.t_s)) > sample.round_trip_ns + kLeap_ns) return false;
  Keep(sample, reading.received_ns / 1'000'000'000);
  return true;
}

// Every telemetry repeats the acknowledgement until the next command: repeats are skipped, not counted.
bool ClockMap::FromAcknowledgement(const ClockReading& reading, Sample& sample) noexcept {
  if (reading.ack_host_us == 0) return false;
  const auto since_us = static_cast<std::int64_t>(static_cast<std::int32_t>(
      static_cast<std::uint32_t>(reading.t_device_us) - reading.ack_rx_device_us));  // t2 - t1
  if (!(since_us >= -kAckAgeMax_us && since_us <= kAckAgeMax_us)) return false;
  if (reading.ack_host_us > static_cast<std::uint64_t>(reading.received_ns) / 1000) {  // before it was sent
    ++refused_;
    return false;
  }
  const std::int64_t t0_ns = Nanoseconds(reading.ack_host_us);
  const std::int64_t t2_ns = Nanoseconds(reading.t_device_us);
  const std::int64_t since_ns = since_us * 1000;
  const auto round_trip_ns = static_cast<double>(reading.received_ns - t0_ns - since_ns);
  if (!(round_trip_ns >= kRoundTripMin_ns && round_trip_ns <= kRoundTripMax_ns)) {
    ++refused_;
    return false;
  }
  const auto there_ns = static_cast<double>(t0_ns - (t2_ns - since_ns) - reference_offset_ns_);
  const auto back_ns = static_cast<double>(reading.received_ns - t2_ns - reference_offset_ns_);
  sample.t_s = Elapsed_s(reading.t_device_us) - 0.5e-6 * static_cast<double>(since_us);
  sample.offset_ns = 0.5 * (there_ns + back_ns);
  sample.round_trip_ns = std::max(round_trip_ns, 0.0);
  return true;
}

void ClockMap::Keep(const Sample& sample, std::int64_t second) noexcept {
  if (has_best_ && second != best_second_) {
    kept_[kept_next_] = best_;
    kept_next_ = (kept_next_ + 1) % kKept;
    kept_count_ = std::min(kept_count_ + 1, kKept);
  }
  const bool better = !has_best_ || second != best_second_ || sample.round_trip_ns < best_.round_trip_ns;
  if (!better) return;
  has_best_ = true;
  best_ = sample;
  best_second_ = second;
  Fit();
}

template <class Visit>
void ClockMap::VisitWindow(Visit&& visit) const noexcept {
  for (std::size_t i = 0; i < kept_count_; ++i) {
    if (best_.t_s - kept_[i].t_s <= kWindow_s) visit(kept_[i]);
  }
  if (has_best_) visit(best_);
}

// Weighted least squares of offset = o + s (t - c) about the weighted centre c, where o and s separate:
// s = Sxy / (Sxx + 1 / sigma_s^2); the last term is the prior for crystals.
void ClockMap::Fit() noexcept {
  const double least_ns = round_trip_us() * 1e3;
  const double noise_ns = kNoise_ns + kHiddenShare * least_ns;
  const auto weight = [least_ns, noise_ns](const Sample& sample) {
    const double sigma_ns = noise_ns + 0.5 * (sample.round_trip_ns - least_ns);
    return 1 / (sigma_ns * sigma_ns);
  };
  double sum = 0;
  double sum_t = 0;
  double sum_offset = 0;
  VisitWindow([&](const Sample& sample) {
    const double w = weight(sample);
    sum += w;
    sum_t += w * sample.t_s;
    sum_offset += w * sample.offset_ns;
  });
  line_.centre_s = sum_t / sum;
  line_.offset_ns = sum_offset / sum;
  double sxx = 1 / (kDriftUsual_ns_per_s * kDriftUsual_ns_per_s);
  double sxy = 0;
  VisitWindow([&](const Sample& sample) {
    const double w = weight(sample);
    const double dt_s = sample.t_s - line_.centre_s;
    sxx += w * dt_s * dt_s;
    sxy += w * dt_s * (sample.offset_ns - line_.offset_ns);
  });
  line_.slope_ns_per_s = std::clamp(sxy / sxx, -kDriftMax_ns_per_s, kDriftMax_ns_per_s);
}

double ClockMap::Elapsed_s(std::uint64_t t_device_us) const noexcept {
  return 1e-6 * static_cast<double>(static_cast<std::int64_t>(t_device_us - reference_device_us_));
}

double ClockMap::Offset_ns(double t_s) const noexcept {
  return line_.offset_ns + line_.slope_ns_per_s * (t_s - line_.centre_s);
}

std::int64_t ClockMap::GiveOut(std::int64_t wanted_ns, bool newer) noexcept {
  const std::int64_t least_ns = given_out_ns_ + (newer ? 1 : 0);
  given_out_ns_ = has_given_out_ ? std::max(wanted_ns, least_ns) : wanted_ns;
  has_given_out_ = true;
  return given_out_ns_;
}

}  // namespace omni::device
