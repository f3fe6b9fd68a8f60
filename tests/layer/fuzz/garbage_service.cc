#include "tests/layer/fuzz/garbage_service.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cmath>
#include <limits>
#include <new>
#include <stdexcept>

#include "service/protocol/state_memory.h"
#include "tests/layer/support/fake_service.h"

namespace omni::test {
namespace {

constexpr std::uint64_t kInstance = 4711;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

double AbsurdNumber(Random& random) {
  static constexpr double kNumbers[] = {0,   1, -1, 1e-300, 1e6, -1e6, 1e300, std::numeric_limits<double>::infinity(),
                                        kNan};
  return random.Percent(60) ? 2 * random.Unit() - 1 : kNumbers[random.Below(9)];
}

}  // namespace

GarbageService::GarbageService() {
  fd_ = memfd_create("omni-garbage", MFD_CLOEXEC | MFD_ALLOW_SEALING);
  if (fd_ < 0 || ftruncate(fd_, sizeof(protocol::StateMemory)) != 0) throw std::runtime_error("memfd_create");
  void* mapped = mmap(nullptr, sizeof(protocol::StateMemory), PROT_READ | PROT_WRITE, MAP_SHARED, fd_, 0);
  if (mapped == MAP_FAILED) throw std::runtime_error("mmap");
  memory_ = new (mapped) protocol::StateMemory;
  memory_->header.total_bytes = sizeof(protocol::StateMemory);
  memory_->header.service_instance = kInstance;
  if (fcntl(fd_, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_FUTURE_WRITE | F_SEAL_SEAL) != 0)
    throw std::runtime_error("F_ADD_SEALS");
  Heal();
  ipc::ServerOptions options;
  options.service_instance = kInstance;
  options.state_fd = fd_;
  auto server = ipc::Server::Open(options, *this);
  if (!server.ok()) throw std::runtime_error(server.error());
  server_ = std::move(server.value());
  server_->Start();
}

GarbageService::~GarbageService() {
  server_->Stop();
  server_.reset();
  munmap(memory_, sizeof(protocol::StateMemory));
  close(fd_);
}

void GarbageService::Publish(const protocol::ToolSample& sample, const protocol::InputSnapshot& inputs) {
  const std::uint64_t sequence = protocol::SequenceOf(published_);
  protocol::StoreCell(memory_->inputs, sequence, inputs);
  protocol::StoreCell(memory_->ring[published_ % protocol::kRingCapacity], sequence, sample);
  ++published_;
  memory_->header.published.store(published_, std::memory_order_release);
}

void GarbageService::Heal() {
  for (int i = 8; i > 0; --i) {
    protocol::ToolSample sample;
    sample.t_ns = Now_ns() - i * 1'000'000;
    sample.flags = protocol::kToolPoseValid | protocol::kToolTracked;
    sample.position_base_m = {0, 0, 0.06};
    protocol::InputSnapshot inputs;
    inputs.t_ns = sample.t_ns;
    Publish(sample, inputs);
  }
}

// Complete, so that the reader has to check its numbers.
protocol::ToolSample GarbageService::Absurd(Random& random) {
  protocol::ToolSample sample;
  sample.t_ns = Now_ns() - 1'000'000 * static_cast<std::int64_t>(random.Below(50));
  if (random.Percent(20)) sample.t_ns = static_cast<std::int64_t>(random.Bits());
  sample.flags = random.Percent(80) ? protocol::kToolPoseValid | protocol::kToolTracked
                                    : static_cast<std::uint32_t>(random.Bits());
  for (double& x : sample.position_base_m) x = AbsurdNumber(random);
  double squared = 0;
  for (double& x : sample.orientation_base_wxyz) {
    x = AbsurdNumber(random);
    squared += x * x;
  }
  // Mostly a rotation, otherwise the sample is rejected for that alone.
  if (random.Percent(80) && squared > 0 && std::isfinite(squared))
    for (double& x : sample.orientation_base_wxyz) x /= std::sqrt(squared);
  for (double& x : sample.linear_velocity_base_m_s) x = AbsurdNumber(random);
  for (double& x : sample.angular_velocity_base_rad_s) x = AbsurdNumber(random);
  sample.position_sigma_m = AbsurdNumber(random);
  sample.gap_m = AbsurdNumber(random);
  return sample;
}

void GarbageService::Scribble(Random& random) {
  switch (random.Below(5)) {
    case 0: {  // any word of the ring
      auto& slot = memory_->ring[random.Below(protocol::kRingCapacity)];
      slot.words[random.Below(static_cast<std::uint32_t>(slot.words.size()))].store(random.Bits(),
                                                                                    std::memory_order_release);
      break;
    }
    case 1:  // a sequence number
      memory_->ring[random.Below(protocol::kRingCapacity)].sequence.store(
          random.Percent(50) ? random.Bits() : protocol::SequenceOf(published_ + random.Below(3)) | random.Below(2),
          std::memory_order_release);
      break;
    case 2:  // the count
      memory_->header.published.store(random.Percent(50) ? random.Bits() : published_ + random.Below(600),
                                      std::memory_order_release);
      break;
    case 3: {  // inputs
      auto& words = memory_->inputs.words;
      words[random.Below(static_cast<std::uint32_t>(words.size()))].store(random.Bits(), std::memory_order_release);
      break;
    }
    default: {
      protocol::InputSnapshot inputs;
      inputs.t_ns = Now_ns();
      for (protocol::InputValue& input : inputs.components) {
        input.value = static_cast<float>(AbsurdNumber(random));
        input.press_count = static_cast<std::uint32_t>(random.Bits());
        input.t_change_ns = static_cast<std::int64_t>(random.Bits() >> random.Below(40));
      }
      Publish(Absurd(random), inputs);
    }
  }
}

}  // namespace omni::test
