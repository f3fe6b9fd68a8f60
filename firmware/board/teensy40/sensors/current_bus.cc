#include "firmware/board/teensy40/sensors/current_bus.h"

#include "firmware/board/teensy40/chip/registers.h"
#include "firmware/board/teensy40/timebase.h"
#include "firmware/drivers/ina260_registers.h"

namespace omni::board {
namespace {

// RM LPI2C: commands of MTDR.
constexpr std::uint32_t kTransmit = 0U << 8, kReceive = 1U << 8, kStop = 2U << 8;
constexpr std::uint32_t kStartExpectNack = 5U << 8, kStartHighSpeed = 6U << 8;

constexpr std::uint32_t kEnable = 1U, kReset = 2U, kEmptyFifos = 3U << 8;  // MCR
constexpr std::uint32_t kSendReady = 1U, kStopSeen = 1U << 9;              // MSR, MIER
constexpr std::uint32_t kReceiveReady = 2U, kNack = 1U << 10;
constexpr std::uint32_t kArbitrationLost = 1U << 11, kFifoError = 1U << 12, kPinLow = 1U << 13;
constexpr std::uint32_t kErrors = kNack | kArbitrationLost | kFifoError | kPinLow;
constexpr std::uint32_t kClearable = 0x7F00;

// Ticks of 30 MHz. A period is low + 1 + high + 1 + 2 of the input filter [RM LPI2C, timing parameters].
constexpr std::uint32_t kPrescaleBy2 = 1;
constexpr std::uint32_t kTick_Hz = kI2cSource_Hz / 2;
struct Timing {
  std::uint32_t low, high, hold, valid;
};
constexpr Timing kFast = {43, 29, 18, 8};     // 395 kHz
constexpr Timing kHighSpeed = {10, 6, 5, 1};  // 1.5 MHz
constexpr std::uint32_t Rate_Hz(const Timing& t) { return kTick_Hz / (t.low + 1 + t.high + 1 + 2); }
static_assert(Rate_Hz(kFast) <= 400'000 && Rate_Hz(kHighSpeed) <= 2'940'000, "INA260, bus timing");
constexpr std::uint32_t Packed(const Timing& t) { return t.low | (t.high << 8) | (t.hold << 16) | (t.valid << 24); }
// A line held low for 100 us is an error: 256 ticks a count [RM LPI2C, MCFGR3].
constexpr std::uint32_t kPinLowCounts = kTick_Hz / 10'000 / 256;

std::uint32_t Received() noexcept { return lpi2c1().MFSR >> 16 & 7; }

}  // namespace

void CurrentBus::Start() noexcept {
  Lpi2c& bus = lpi2c1();
  bus.MCR = kReset;
  bus.MCR = 0;
  bus.MIER = 0;
  bus.MCFGR0 = 0;
  bus.MCFGR1 = kPrescaleBy2;
  bus.MCFGR2 = 0;
  bus.MCFGR3 = kPinLowCounts << 8;
  bus.MCCR0 = Packed(kFast);
  bus.MCCR1 = Packed(kHighSpeed);
  bus.MFCR = 1U << 16;  // ready to read with both bytes of a register
  bus.MCR = kEnable;
  busy_ = false;
}

void CurrentBus::Begin(I2cJob* jobs, int count) noexcept {
  if (busy_) GiveUp();
  jobs_ = jobs;
  count_ = count > kJobsMax ? kJobsMax : count;
  for (int i = 0; i < count_; ++i) {
    jobs[i].status = drivers::BusStatus::kTimeout;
    jobs[i].failed = false;
  }
  pushed_ = read_ = 0;
  busy_ = count_ > 0;
  if (busy_) Launch();
}

// The master code alone: a job's four words fill the controller's queue of four.
void CurrentBus::Launch() noexcept {
  Lpi2c& bus = lpi2c1();
  stopping_ = false;
  bus.MCR = kEnable | kEmptyFifos;
  bus.MSR = kClearable;
  bus.MTDR = kStartExpectNack | drivers::ina260::kHighSpeedMasterCode;
  bus.MIER = kSendReady | kReceiveReady | kStopSeen | kErrors;
}

void CurrentBus::Push(const I2cJob& job) noexcept {
  Lpi2c& bus = lpi2c1();
  if (job.out_size > 0) {
    bus.MTDR = kStartHighSpeed | static_cast<std::uint32_t>(job.address << 1);
    for (int i = 0; i < job.out_size; ++i) bus.MTDR = kTransmit | job.out[i];
  }
  if (job.read) {
    bus.MTDR = kStartHighSpeed | static_cast<std::uint32_t>(job.address << 1 | 1);
    bus.MTDR = kReceive | (sizeof job.in - 1);
  }
}

void CurrentBus::Collect() noexcept {
  while (read_ < pushed_ && !jobs_[read_].read) ++read_;
  if (read_ >= pushed_ || Received() < sizeof jobs_->in) return;
  I2cJob& job = jobs_[read_++];
  job.in[0] = static_cast<std::uint8_t>(lpi2c1().MRDR);
  job.in[1] = static_cast<std::uint8_t>(lpi2c1().MRDR);
  job.status = drivers::BusStatus::kOk;
}

void CurrentBus::Finish() noexcept {
  lpi2c1().MIER = 0;
  // Write-only jobs are done when the session has ended without error.
  for (int i = 0; i < count_; ++i) {
    if (!jobs_[i].read && !jobs_[i].failed) jobs_[i].status = drivers::BusStatus::kOk;
  }
  busy_ = false;
}

// The job on the bus is lost, the others continue. After a NACK the controller sends a stop by itself.
void CurrentBus::Fail(drivers::BusStatus status) noexcept {
  const int at = pushed_ > 0 ? pushed_ - 1 : 0;
  jobs_[at].status = status;
  jobs_[at].failed = true;
  if (pushed_ == 0)
    pushed_ = 1;  // the master code failed: the bus itself is faulty; skip a job so that the session ends
  read_ = pushed_;
  if (pushed_ < count_) {
    Launch();
    return;
  }
  lpi2c1().MCR = kEnable | kEmptyFifos;
  lpi2c1().MSR = kClearable;
  lpi2c1().MIER = 0;
  busy_ = false;
}

void CurrentBus::GiveUp() noexcept {
  lpi2c1().MIER = 0;
  busy_ = false;
  Start();  // resets the controller, which releases both lines
}

void CurrentBus::Advance() noexcept {
  Lpi2c& bus = lpi2c1();
  if (pushed_ < count_) {
    Push(jobs_[pushed_++]);
  } else if (!stopping_) {
    bus.MTDR = kStop;
    bus.MIER = kReceiveReady | kStopSeen | kErrors;
    stopping_ = true;
  }
}

void CurrentBus::HandleInterrupt() noexcept {
  if (!busy_) {
    lpi2c1().MIER = 0;
    return;
  }
  Collect();
  const std::uint32_t flags = lpi2c1().MSR;
  if ((flags & kErrors) != 0) {
    Fail((flags & kNack) != 0 ? drivers::BusStatus::kNack : drivers::BusStatus::kTimeout);
  } else if (stopping_ && (flags & kStopSeen) != 0) {
    Collect();
    lpi2c1().MSR = kStopSeen;
    Finish();
  } else if (!stopping_ && (flags & kSendReady) != 0) {
    Advance();
  }
  DataBarrier();
}

drivers::BusStatus CurrentBus::Transfer(std::uint8_t address, const std::uint8_t* out, std::size_t out_size,
                                        std::uint8_t* in, std::size_t in_size) noexcept {
  I2cJob job;
  if (out_size > sizeof job.out || (in_size != 0 && in_size != sizeof job.in)) return drivers::BusStatus::kTimeout;
  job.address = address;
  for (std::size_t i = 0; i < out_size; ++i) job.out[i] = out[i];
  job.out_size = static_cast<std::uint8_t>(out_size);
  job.read = in_size != 0;
  nvic::Disable(Irq::kLpi2c1);
  const std::uint32_t begin = Timebase::NowLow32_us();
  Begin(&job, 1);
  while (busy_ && Timebase::NowLow32_us() - begin < kPollBound_us) HandleInterrupt();
  if (busy_) GiveUp();
  nvic::Enable(Irq::kLpi2c1, Priority::kHigh);
  for (std::size_t i = 0; i < in_size; ++i) in[i] = job.in[i];
  return job.status;
}

}  // namespace omni::board
