#include "tests/support/rig/scan_faults.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace {

using base::HallScan;
using base::Vec3;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kRange_T = support::NominalDevice().sensor_range_T;

template <class Change>
void ForSensors(const FaultContext& context, HallScan& scan, Change change) {
  for (std::size_t i = 0; i < scan.field_sensor_T.size(); ++i) {
    if ((context.sensors >> i) & 1U) change(i, scan.field_sensor_T[i]);
  }
}

void None(FaultContext&, HallScan&) {}

void NotANumber(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t i, Vec3& field) { (i % 2 == 0 ? field.x : field.z) = kNan; });
}

void Infinite(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t i, Vec3& field) { field.y = i % 2 == 0 ? kInfinity : -kInfinity; });
}

void Huge(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field = {1e300, -1e300, 1e-300}; });
}

void Stuck(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t i, Vec3& field) { field = context.held.field_sensor_T[i]; });
}

void StuckAtZero(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field = {}; });
}

void Saturated(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t i, Vec3& field) {
    field = {std::copysign(kRange_T, field.x), std::copysign(kRange_T, field.y), std::copysign(kRange_T, field.z)};
    scan.saturated_mask |= 7U << (3 * i);
  });
}

// At full scale, but not reported by the device.
void SaturatedSilently(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field.x = kRange_T; });
}

void Missing(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t i, Vec3&) {
    scan.age_ns[i] = i % 2 == 0 ? 1'000'000'000 : std::numeric_limits<std::int64_t>::min();
  });
  scan.fresh_mask &= ~context.sensors;
}

void Swapped(FaultContext& context, HallScan& scan) {
  std::size_t first = 0;
  while (((context.sensors >> first) & 1U) == 0) ++first;
  std::swap(scan.field_sensor_T[first], scan.field_sensor_T[(first + 3) % base::kSensorCount]);
}

void Gauss(FaultContext&, HallScan& scan) {
  for (Vec3& field : scan.field_sensor_T) field = 1e4 * field;
}

void Microtesla(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field = 1e6 * field; });
}

void Weaker(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field = 0.5 * field; });
}

void SignFlipped(FaultContext& context, HallScan& scan) {
  ForSensors(context, scan, [&](std::size_t, Vec3& field) { field = -1 * field; });
}

void TwoMagnets(FaultContext& context, HallScan& scan) {
  for (std::size_t i = 0; i < scan.field_sensor_T.size(); ++i) {
    scan.field_sensor_T[i] = scan.field_sensor_T[i] + context.other_magnet[i];
  }
}

void PenRemoved(FaultContext& context, HallScan& scan) {
  scan.saturated_mask = 0;
  for (std::size_t i = 0; i < scan.field_sensor_T.size(); ++i) {
    scan.field_sensor_T[i] = context.no_pen[i] + context.random.NormalVector(context.noise_T);
  }
}

void SetCurrents(HallScan& scan, const std::array<double, base::kCoilCount>& current_A) {
  scan.coil_current_A = current_A;
  scan.step_current_A.fill(current_A);
}
void CurrentNotANumber(FaultContext&, HallScan& scan) { SetCurrents(scan, {kNan, 1, kInfinity}); }
void CurrentHuge(FaultContext&, HallScan& scan) { SetCurrents(scan, {1e200, -1e9, 400}); }
void CurrentWrong(FaultContext&, HallScan& scan) {
  scan.coil_current_A[1] += 5;
  for (auto& step_A : scan.step_current_A) step_A[1] += 5;
}
// One control step alone: it contradicts its neighbours and does not show in the mean.
void CurrentStepLies(FaultContext& context, HallScan& scan) {
  const std::array<double, 4> values{kNan, kInfinity, 1e200, 40};
  scan.step_current_A[context.random.Bits() % 4][context.random.Bits() % 3] = values[context.random.Bits() % 4];
}
void TickLeadLies(FaultContext& context, HallScan& scan) {
  scan.tick_lead_ns = context.random.Bits() & 1U ? static_cast<std::int64_t>(context.random.Bits()) : -1;
}

void TimeBackwards(FaultContext& context, HallScan& scan) {
  scan.t_ns -= static_cast<std::int64_t>(context.random.Uniform(0, 1e10));
}
void TimeExtreme(FaultContext& context, HallScan& scan) {
  scan.t_ns =
      context.random.Bits() & 1U ? std::numeric_limits<std::int64_t>::max() : std::numeric_limits<std::int64_t>::min();
}
void TimeStands(FaultContext& context, HallScan& scan) { scan.t_ns = context.held.t_ns; }
void SequenceJumps(FaultContext& context, HallScan& scan) { scan.sequence = context.random.Bits(); }

void DeviceFault(FaultContext& context, HallScan& scan) {
  scan.device_faults = static_cast<std::uint32_t>(context.random.Bits()) | 1U;
}
void Temperature(FaultContext& context, HallScan& scan) {
  const std::array<double, 4> values{kNan, kInfinity, -1e9, 150};
  scan.coil_temperature_C[context.random.Bits() % 3] = values[context.random.Bits() % 4];
}
void Supply(FaultContext& context, HallScan& scan) {
  const std::array<double, 4> values{kNan, kInfinity, -12, 0};
  scan.supply_V = values[context.random.Bits() % 4];
}

// Any bits at all.
void RandomBits(FaultContext& context, HallScan& scan) {
  std::array<std::uint64_t, (sizeof(HallScan) + 7) / 8> bits{};
  for (std::uint64_t& word : bits) word = context.random.Bits();
  std::memcpy(static_cast<void*>(&scan), bits.data(), sizeof scan);
}

constexpr ScanFault kFaults[] = {
    {"none", None, true},
    {"not a number", NotANumber, true},
    {"infinite", Infinite, true},
    {"huge", Huge, true},
    {"stuck", Stuck, true},
    {"stuck at zero", StuckAtZero, true},
    {"saturated", Saturated, true},
    {"saturated silently", SaturatedSilently, true},
    {"missing", Missing, true},
    {"swapped", Swapped, true},
    {"gauss for tesla", Gauss, true},
    {"microtesla, some", Microtesla, true},
    {"half gain, some", Weaker, true},
    {"sign flipped, some", SignFlipped, true},
    {"two magnets", TwoMagnets, true},
    {"pen removed", PenRemoved, false},
    {"current not finite", CurrentNotANumber, true},
    {"current huge", CurrentHuge, true},
    {"current 5 A wrong", CurrentWrong, true},
    {"current step lies", CurrentStepLies, true},
    {"tick lead lies", TickLeadLies, true},
    {"time backwards", TimeBackwards, true},
    {"time extreme", TimeExtreme, true},
    {"time stands", TimeStands, true},
    {"sequence jumps", SequenceJumps, true},
    {"device fault", DeviceFault, true},
    {"temperature", Temperature, true},
    {"supply", Supply, true},
    {"random bits", RandomBits, false},
};

}  // namespace

std::span<const ScanFault> ScanFaults() { return kFaults; }

}  // namespace omni::sim
