// The state memory: a memfd written by omnid's tick thread, mapped read-only by clients.
//
//   [StateHeader][InputBlock][ContactBlock][VehicleBlock][RingSlot x kRingCapacity][TelemetrySlot x kRingCapacity]
//   [BaseSlot x kBaseRingCapacity]
//
// Every shared word is a lock-free std::atomic<uint64_t>. A slot is a seqlock: `sequence` is odd while the writer
// is inside, and 2 * (publication index + 1) when slot `index % kRingCapacity` holds publication `index`.
// Readers copy the words (acquire loads), check the sequence again and give up after 3 torn reads. Telemetry of a
// publication is in the slot of the same index, written before it counts as published. Base slots have a count of their
// own, and are written by the control thread.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "service/base/life_page.h"

namespace omni::protocol {

inline constexpr std::uint32_t kStateMagic = 0x54534D4F;  // "OMST"
inline constexpr std::uint32_t kStateVersion = 5;         // 2: contacts; 3: vehicle; 4: telemetry; 5: base
inline constexpr std::uint32_t kRingCapacity = 512;       // >= 250 ms at 1 kHz
inline constexpr std::uint32_t kBaseRingCapacity = 512;   // the same, for a robot that reports each millisecond
inline constexpr int kMaxTornReads = 3;

enum ToolFlag : std::uint32_t {
  kToolPoseValid = 1u << 0,          // there is a pose (maybe the last known one)
  kToolTracked = 1u << 1,            // this sample was measured
  kToolContact = 1u << 2,            // force is being rendered
  kToolJoystick = 1u << 3,           // the active scene says joystick: thumbstick components are live
  kToolAligned = 1u << 4,            // base pose in the headset's space is known (else the default base pose holds)
  kToolPushed = 1u << 5,             // a force or a constraint of the application acts
  kToolForceCut = 1u << 6,           // the device's limit cut the force
  kToolWarm = 1u << 7,               // coils may carry less current than cold ones
  kToolOutOfReach = 1u << 8,         // no force can be made at this pose
  kToolDeviceFault = 1u << 9,        // the device reports a fault: no force
  kToolStiffnessLimited = 1u << 10,  // constraints are softer or less damped than requested
  kToolHolding = 1u << 11,           // the tip holds a face or a sculpted surface, which follows it
  kToolSoftened = 1u << 12,          // what is touched gave the hand energy or made it swing, and is softer for a while
  kToolWaits = 1u << 13  // the tip is inside what appeared around it or was pushed through: no force until out
};

// Frame T of the tool: origin at the device point (tip), -Z out of the tip along the pen's axis; roll about the axis
// is not observable and is carried on by minimal twist. Frame B: base, see docs/conventions.md. SI.
struct ToolSample {
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC of the Hall sample
  std::uint32_t flags = 0;
  std::uint32_t contact_count = 0;          // surfaces touched
  std::array<double, 3> position_base_m{};  // device point
  std::array<double, 4> orientation_base_wxyz{1, 0, 0, 0};
  std::array<double, 3> linear_velocity_base_m_s{};  // of the device point
  std::array<double, 3> angular_velocity_base_rad_s{};
  std::array<double, 3> force_base_N{};  // commanded to the tool
  double position_sigma_m = 0;           // 1 sigma of the tracker, norm over axes
  double gap_m = 0;
};
static_assert(std::is_trivially_copyable_v<ToolSample> && sizeof(ToolSample) % 8 == 0);

// Mirrors base::InputState: what the layer snapshots at xrSyncActions. Index = InputIndex.
enum class InputIndex : std::uint32_t {
  kTipForce = 0,
  kSelect,
  kSecondary,
  kMenu,
  kSqueeze,
  kThumbstickX,
  kThumbstickY,
  kThumbstickClick,
  kDocked,
  kCount
};
inline constexpr std::uint32_t kInputCount = static_cast<std::uint32_t>(InputIndex::kCount);

struct InputValue {
  float value = 0;
  std::uint32_t press_count = 0;  // edges over 0.5, since the service started
  std::uint32_t release_count = 0;
  std::uint32_t reserved = 0;
  std::int64_t t_change_ns = 0;  // physical time of the last change
};
struct InputSnapshot {
  std::int64_t t_ns = 0;
  std::array<InputValue, kInputCount> components{};
};
static_assert(std::is_trivially_copyable_v<InputSnapshot> && sizeof(InputSnapshot) % 8 == 0);

// What the tip touches, in the frame B. Objects and materials are numbered as in the scene.
inline constexpr std::uint32_t kMaxSampledContacts = 4;
struct ContactSample {
  std::uint32_t object = 0;
  std::uint32_t material = 0;
  std::array<double, 3> point_base_m{};   // on the surface
  std::array<double, 3> normal_base{};    // unit, towards the side the tip came from
  std::array<double, 3> force_base_N{};   // requested by the contact, on the tip, before the device's limits
  std::array<double, 3> slip_base_m_s{};  // of the tip along the surface, relative to it
  double normal_force_N = 0, tangential_force_N = 0;
  double penetration_m = 0;
};
struct ContactSnapshot {
  std::int64_t t_ns = 0;               // CLOCK_MONOTONIC of the Hall sample
  std::uint64_t scene_generation = 0;  // of the scene that is touched
  std::uint32_t count = 0;
  std::uint32_t reserved = 0;
  std::array<ContactSample, kMaxSampledContacts> contacts{};
};
static_assert(std::is_trivially_copyable_v<ContactSnapshot> && sizeof(ContactSnapshot) % 8 == 0);

// The car of the active scene, in the frame B: for drawing it, and the state of the race.
struct VehicleSnapshot {
  std::int64_t t_ns = 0;                    // CLOCK_MONOTONIC of the Hall sample
  std::uint64_t scene_generation = 0;       // of the scene
  std::uint32_t on = 0;                     // 1: the scene has a car; 0: the rest is meaningless
  std::uint32_t sliding = 0;                // 1: an axle is at the limit of its grip
  std::uint32_t laps = 0, hits = 0;         // finished so far
  std::array<double, 3> position_base_m{};  // centre of mass
  double heading_rad = 0;                   // about +z, 0 = +x
  double speed_m_s = 0;                     // along the heading
  double lap_s = 0;                         // time of the lap being driven; 0: none is
  double last_lap_s = 0, best_lap_s = 0;    // 0: none yet
};
static_assert(std::is_trivially_copyable_v<VehicleSnapshot> && sizeof(VehicleSnapshot) % 8 == 0);

// How the device and the tick are, for people and monitors: of the scan of the ToolSample with the same index.
struct TelemetrySample {
  std::uint32_t tick_faults = 0;           // loop::TickFault bits
  std::uint32_t device_faults = 0;         // wire::Fault bits (docs/protocol/faults.md)
  std::uint32_t tool_limits = 0;           // base::ToolLimit bits
  std::uint32_t sensors_left_out = 0;      // bit i: the tracker ignores sensor i
  std::uint32_t saturated_mask = 0;        // bit 3 i + axis: that sensor axis is at its limit
  std::uint32_t tick_ns = 0;               // how long Tick took
  std::uint32_t latency_ns = 0;            // from the Hall sample until the currents were sent
  std::uint32_t fit_dof = 0;               // degrees of freedom of the fit
  std::array<float, 3> current_A{};        // as sent
  std::array<float, 3> measured_A{};       // mean over the device's tick
  std::array<float, 3> coil_C{};           // temperatures as the device estimates them
  std::array<float, 3> ambient_T{};        // uniform field since the calibration, frame B
  std::array<float, 2> tip_variance_m2{};  // of the device point, 1 sigma squared: worst direction, along the axis
  float supply_V = 0;
  float fit_chi2 = 0;     // of this scan's fit; fit_dof is expected
  float field_T = 0;      // of the tool at the sensors, root mean square
  float stray_T = 0;      // of other magnets, root mean square; 0: none
  float model_error = 0;  // relative error of the tool's field in the calibration, as the tracker estimates it
  float gate = 0;         // 0 ... 1, gain on everything rendered
};
static_assert(std::is_trivially_copyable_v<TelemetrySample> && sizeof(TelemetrySample) % 8 == 0);

// Where a base that moves is, in the reference space L of a headset (messages BasePose, BaseMotion).
enum BaseFlag : std::uint32_t {
  kBaseSeen = 1u << 0,  // its source sees it; else this is its last known pose
  kBaseLeapt = 1u << 1  // no base moves so fast: nothing is known between the sample before and this one
};
struct BaseSample {
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC when it is there
  std::uint32_t flags = 0;
  std::int32_t space = 2;                    // XrReferenceSpaceType of L
  std::array<double, 3> position_space_m{};  // of B's origin
  std::array<double, 4> orientation_space_wxyz{1, 0, 0, 0};
  std::array<double, 3> linear_velocity_space_m_s{};  // of B's origin
  std::array<double, 3> angular_velocity_space_rad_s{};
};
static_assert(std::is_trivially_copyable_v<BaseSample> && sizeof(BaseSample) % 8 == 0);

using Word = std::atomic<std::uint64_t>;
static_assert(Word::is_always_lock_free && sizeof(Word) == 8);

template <class T>
struct SeqlockCell {
  static constexpr std::size_t kWords = sizeof(T) / 8;
  Word sequence{0};
  std::array<Word, kWords> words{};
};

using RingSlot = SeqlockCell<ToolSample>;
using InputBlock = SeqlockCell<InputSnapshot>;
using ContactBlock = SeqlockCell<ContactSnapshot>;
using VehicleBlock = SeqlockCell<VehicleSnapshot>;
using TelemetrySlot = SeqlockCell<TelemetrySample>;
using BaseSlot = SeqlockCell<BaseSample>;

struct StateHeader {
  std::uint32_t magic = kStateMagic;
  std::uint32_t version = kStateVersion;
  std::uint32_t total_bytes = 0;
  std::uint32_t ring_capacity = kRingCapacity;
  std::uint32_t slot_bytes = sizeof(RingSlot);
  std::uint32_t input_bytes = sizeof(InputBlock);
  std::uint32_t contact_bytes = sizeof(ContactBlock);
  std::uint32_t vehicle_bytes = sizeof(VehicleBlock);
  std::uint32_t telemetry_bytes = sizeof(TelemetrySlot);
  std::uint32_t base_bytes = sizeof(BaseSlot);
  std::uint64_t service_instance = 0;
  Word published{0};        // number of samples published so far; newest index = published - 1
  Word bases_published{0};  // the same of base samples
};

struct StateMemory {
  StateHeader header;
  alignas(64) InputBlock inputs;
  alignas(64) ContactBlock contacts;
  alignas(64) VehicleBlock vehicle;
  alignas(64) std::array<RingSlot, kRingCapacity> ring;
  alignas(64) std::array<TelemetrySlot, kRingCapacity> telemetry;
  alignas(64) std::array<BaseSlot, kBaseRingCapacity> bases;
};

// A client's own writable page. Every intercepted call is a sign of life, without a system call.
using LifePage = base::LifePage;
inline constexpr std::uint32_t kLifePageBytes = 4096;

// The seqlock, both sides. One writer, any number of readers; neither side ever waits.
//
// No fences: every shared word is stored with release and loaded with acquire order. A reader that saw a word of a
// newer value has thereby also seen the odd sequence stored before it, so its second read of the sequence differs.
// This work is based on H.-J. Boehm, "Can seqlocks get along with programming language memory models?" (2012).
//
// Sequence of a cell that holds publication `index` (counted from 0).
constexpr std::uint64_t SequenceOf(std::uint64_t index) noexcept { return 2 * (index + 1); }

// Writer only. `sequence` is even and differs from the cell's present one.
template <class T>
void StoreCell(SeqlockCell<T>& cell, std::uint64_t sequence, const T& value) noexcept {
  std::array<std::uint64_t, SeqlockCell<T>::kWords> raw;
  std::memcpy(raw.data(), &value, sizeof(T));
  cell.sequence.store(sequence - 1, std::memory_order_release);
  for (std::size_t i = 0; i < raw.size(); ++i) cell.words[i].store(raw[i], std::memory_order_release);
  cell.sequence.store(sequence, std::memory_order_release);
}

// One attempt to read. Returns the sequence that `value` belongs to; 0: never written, or torn (`value` untouched).
template <class T>
std::uint64_t LoadCell(const SeqlockCell<T>& cell, T& value) noexcept {
  const std::uint64_t sequence = cell.sequence.load(std::memory_order_acquire);
  if (sequence % 2 != 0) return 0;
  std::array<std::uint64_t, SeqlockCell<T>::kWords> raw;
  for (std::size_t i = 0; i < raw.size(); ++i) raw[i] = cell.words[i].load(std::memory_order_acquire);
  if (sequence == 0 || cell.sequence.load(std::memory_order_acquire) != sequence) return 0;
  std::memcpy(static_cast<void*>(&value), raw.data(), sizeof(T));
  return sequence;
}

}  // namespace omni::protocol
