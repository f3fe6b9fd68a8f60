// Maps a base's own clock (microseconds since its reset, crystal within +-50 ppm) to the host's CLOCK_MONOTONIC.
//
// From acknowledged commands, as NTP does [RFC 5905, 8]: t0 host sends, t1 base receives, t2 base stamps its telemetry,
// t3 host receives that.
//
//   host - device = ((t0 - t1) + (t3 - t2)) / 2 + (path back - path there) / 2,   round trip = (t3 - t0) - (t2 - t1)
//
// so no sample is wrong by more than half its round trip, and the sample of the least round trip is the best one. One
// sample a second is kept, and a line is fitted through those of the last 30 s, weighted by how much their round trip
// exceeds the least. What remains is half the asymmetry of the two fastest paths; with jitter of 0.3 ms there and 1 ms
// back (means) and crystals of +-100 ppm that value is reached within 150 us after 0.3 s, 60 us after 3 s and 25 us
// after 10 s (tests/device/clock_map.cc).
//
// t2 is the instant of the newest Hall sample, so the path back includes the time from then to sending.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace omni::device {

// What one telemetry frame says about the two clocks.
struct ClockReading {
  std::uint64_t t_device_us = 0;       // of the header: t2
  std::int64_t received_ns = 0;        // CLOCK_MONOTONIC of its arrival: t3, never less than that of the reading before
  std::uint64_t ack_host_us = 0;       // Telemetry: t0; 0: no command acknowledged yet
  std::uint32_t ack_rx_device_us = 0;  // Telemetry: low 32 bits of t1
};

// One thread. No clock of its own, no allocation.
class ClockMap {
 public:
  // Adds the reading and returns the host's time of its t_device_us, ns. Over calls this never goes back, and grows
  // with every larger stamp. It is not later than received_ns, unless that would make it go back.
  //
  // Before the first acknowledged command: as if the fastest frame so far had needed no time. A stamp that goes back,
  // or a clock that leaps (by more than the round trip and 1 ms), is a reset of the base: the map restarts. An
  // impossible reading (see `refused`) changes nothing and returns received_ns.
  std::int64_t Add(const ClockReading& reading) noexcept;

  // The host's time of another device instant, ns, by the current fit: of a FAULT's t_us, for example. 0 before the
  // first reading, and for an impossible instant.
  std::int64_t HostTime_ns(std::uint64_t t_device_us) const noexcept;

  // Forgets the device, but not the times already returned: the next reading starts a new map.
  void Restart() noexcept;

  bool acknowledged() const noexcept { return has_best_; }       // false: mapped by arrival alone
  double drift_ppm() const noexcept;                             // > 0: the device's clock is slow
  double round_trip_us() const noexcept;                         // least one of the window; 0 before the first
  std::uint64_t refused() const noexcept { return refused_; }    // impossible readings or acknowledgements
  std::uint64_t restarts() const noexcept { return restarts_; }  // after backward stamps or leaps; not Restart()

 private:
  static constexpr std::size_t kKept = 32;  // seconds; the oldest is replaced

  struct Sample {
    double t_s = 0;        // device time after reference_device_us_
    double offset_ns = 0;  // host - device, less reference_offset_ns_
    double round_trip_ns = 0;
  };
  struct Line {
    double centre_s = 0;
    double offset_ns = 0;  // at centre_s
    double slope_ns_per_s = 0;
  };

  void Begin(const ClockReading& reading) noexcept;
  void TakeArrival(const ClockReading& reading) noexcept;
  bool TakeAcknowledgement(const ClockReading& reading) noexcept;
  bool FromAcknowledgement(const ClockReading& reading, Sample& sample) noexcept;
  void Keep(const Sample& sample, std::int64_t second) noexcept;
  void Fit() noexcept;
  template <class Visit>
  void VisitWindow(Visit&& visit) const noexcept;
  double Elapsed_s(std::uint64_t t_device_us) const noexcept;
  double Offset_ns(double t_s) const noexcept;
  std::int64_t GiveOut(std::int64_t wanted_ns, bool newer) noexcept;

  std::uint64_t reference_device_us_ = 0;
  std::int64_t reference_offset_ns_ = 0;
  std::uint64_t newest_device_us_ = 0;
  Line line_;
  std::array<Sample, kKept> kept_{};  // the best of each full second
  std::size_t kept_count_ = 0;
  std::size_t kept_next_ = 0;
  Sample best_;  // of the current second
  std::int64_t best_second_ = 0;
  std::int64_t given_out_ns_ = 0;
  std::uint64_t refused_ = 0;
  std::uint64_t restarts_ = 0;
  bool begun_ = false;
  bool has_best_ = false;
  bool has_given_out_ = false;
};

}  // namespace omni::device
