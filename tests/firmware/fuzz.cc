// Arbitrary input, by frame or by sensor: no crash (ASan checks), duty in range, and none unless armed or testing.
// scripts/fuzz runs more than a test run has time for, through OMNI_FUZZ.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <random>
#include <string>
#include <utility>

#include "firmware/wire/frame.h"
#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_fuzz {

using wire::State;

std::int64_t FrameCount() {
  const char* asked = std::getenv("OMNI_FUZZ");
  return asked != nullptr ? std::atoll(asked) : 1'000'000;
}

// Duty only where coils may be driven, and in the ramp to zero just after.
class DutyWatch {
 public:
  bool IsUnsafe(const Outputs& outputs, State state) {
    const bool may_drive = state == State::kArmed || state == State::kSelfTest;
    steps_since_ = may_drive ? 0 : steps_since_ + 1;
    for (const std::int16_t duty : outputs.duty) {
      if (duty < -wire::kDutyFull) return true;
      if (duty != 0 && (outputs.awake != 7 || steps_since_ > kRampMax_steps)) return true;
    }
    return false;
  }

 private:
  static constexpr int kRampMax_steps = 20;  // 5 ms

  int steps_since_ = kRampMax_steps;
};

// For scripts/fuzz.
void Figures(std::initializer_list<std::pair<const char*, std::int64_t>> figures) {
  for (const auto& [name, value] : figures) testing::Test::RecordProperty(name, std::to_string(value));
}

void SayHello(FirmwareBench& bench) {
  Bytes ask(wire::kFrameSizeMax);
  ask.resize(wire::SealFrame(wire::Header{}, 0, ask.data(), ask.size()).size);
  bench.Receive(ask);
}

class RandomFrames {
 public:
  explicit RandomFrames(std::uint64_t seed) : random_(seed) {}

  // Noise, frames of the right shape with random contents, and real ones with a few bits flipped.
  std::size_t Next(std::uint8_t* frame) {
    switch (random_() % 4) {
      case 0:
        return Noise(frame);
      case 1:
        return Shaped(frame, random_() % 8 == 0);
      case 2: {
        const std::size_t size = Shaped(frame, false);
        if (size > 0) frame[random_() % size] ^= static_cast<std::uint8_t>(1U << random_() % 8);
        return size;
      }
      default:
        return Real(frame);
    }
  }

 private:
  std::size_t Noise(std::uint8_t* frame) {
    const std::size_t size = random_() % (wire::kFrameSizeMax + 1);
    for (std::size_t i = 0; i < size; ++i) frame[i] = static_cast<std::uint8_t>(random_());
    return size;
  }
  std::size_t Shaped(std::uint8_t* frame, bool any_size) {
    const std::size_t size = any_size ? random_() % (wire::kPayloadSizeMax + 1) : random_() % 48;
    for (std::size_t i = 0; i < size; ++i) frame[wire::kHeaderSize + i] = static_cast<std::uint8_t>(random_());
    wire::Header header;
    header.type = static_cast<wire::MessageType>(random_() % 10);
    header.seq = static_cast<std::uint16_t>(random_());
    return wire::SealFrame(header, size, frame, wire::kFrameSizeMax).size;
  }
  std::size_t Real(std::uint8_t* frame) {
    ++seq_;
    if (random_() % 16 == 0) {
      wire::Config config;
      config.op = static_cast<wire::ConfigOp>(1 + random_() % 4);
      config.id = static_cast<std::uint16_t>(random_() % 40);
      config.value = std::uniform_real_distribution<float>(-100, 1000)(random_);
      return wire::Encode(config, seq_, 0, frame, wire::kFrameSizeMax).size;
    }
    if (random_() % 16 == 0) {
      wire::Arm arm;
      arm.step = static_cast<wire::ArmStep>(1 + random_() % 5);
      arm.nonce = static_cast<std::uint32_t>(random_());
      return wire::Encode(arm, seq_, 0, frame, wire::kFrameSizeMax).size;
    }
    wire::Command command;
    command.mode = static_cast<wire::Mode>(random_() % 2);
    command.time_to_live_ms = static_cast<std::uint16_t>(1 + random_() % 20);
    for (float& set_point_A : command.set_point_A) {
      set_point_A = std::uniform_real_distribution<float>(-15, 15)(random_);
    }
    command.host_us = ++host_us_;
    return wire::EncodeCommand(command, 15, seq_, frame, wire::kFrameSizeMax).size;
  }

  std::mt19937_64 random_;
  std::uint16_t seq_ = 0;
  std::uint64_t host_us_ = 0;
};

// No such frame ever arms, so no coil ever carries current.
TEST(FirmwareFuzz, RandomFramesNeverArm) {
  FirmwareBench bench;
  bench.host_speaks = false;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  RandomFrames frames(1);
  DutyWatch duty;
  double largest_A = 0;
  std::int64_t armed = 0, unsafe = 0;
  const std::int64_t count = FrameCount();
  for (std::int64_t i = 0; i < count && armed + unsafe == 0; ++i) {
    std::uint8_t frame[wire::kFrameSizeMax];
    const std::size_t size = frames.Next(frame);
    // A block of exactly this size, so that a read past its end is seen.
    const auto exact = std::make_unique<std::uint8_t[]>(size);
    std::copy(frame, frame + size, exact.get());
    bench.core.Receive(exact.get(), size);
    if (i % 8 != 0) continue;
    bench.Step();
    bench.answers.clear();
    largest_A = std::max(largest_A, bench.plant.largest_A());
    unsafe += duty.IsUnsafe(bench.outputs, bench.core.state()) ? 1 : 0;
    armed += bench.core.state() == State::kArmed ? 1 : 0;
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_EQ(armed, 0);
  EXPECT_LT(largest_A, 1.2);  // a self-test after ESTOP has one ampere
  EXPECT_EQ(bench.bad_frames, 0);
  Figures({{"frames", count}, {"armed", armed}, {"unsafe", unsafe}, {"largest_mA", std::llround(1000 * largest_A)}});
}

// Armed, with real commands among the noise: within limits, and it ends when the valid ones end.
TEST(FirmwareFuzz, ArmedNoiseStaysWithinLimits) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunToArmed());
  bench.host_speaks = false;
  RandomFrames frames(2);
  DutyWatch duty;
  double largest_A = 0;
  std::int64_t armed = 0, unsafe = 0;
  const std::int64_t count = FrameCount() / 4;
  for (std::int64_t i = 0; i < count && unsafe == 0; ++i) {
    std::uint8_t frame[wire::kFrameSizeMax];
    bench.core.Receive(frame, frames.Next(frame));
    bench.Step();
    bench.answers.clear();
    unsafe += duty.IsUnsafe(bench.outputs, bench.core.state()) ? 1 : 0;
    largest_A = std::max(largest_A, bench.plant.largest_A());
    if (bench.core.state() == State::kArmed) {
      ++armed;
    } else if (i % 40 == 0) {
      SayHello(bench);  // the noise has sent HELLO with other versions
      bench.Arm();
    }
  }
  EXPECT_EQ(unsafe, 0);
  EXPECT_LT(largest_A, 15.5);
  EXPECT_GT(largest_A, 1);
  EXPECT_GT(armed, count / 100);
  Figures(
      {{"frames", count}, {"steps_armed", armed}, {"unsafe", unsafe}, {"largest_mA", std::llround(1000 * largest_A)}});
}

// Arbitrary sensor values: faults, no crash, no duty out of range, numbers stay finite.
TEST(FirmwareFuzz, RandomInputsCauseFaultsNotUnsafeDuties) {
  std::mt19937_64 random(3);
  for (int life = 0; life < 20; ++life) {
    FirmwareBench bench;
    ASSERT_TRUE(bench.RunToArmed());
    bench.SetAll(8);
    bench.RunMs(10);
    const int kind = life % 4;
    DutyWatch duty;
    Inputs inputs = bench.plant.inputs();
    for (int step = 0; step < 5000; ++step) {
      if (kind == 0) {
        inputs = bench.plant.Step(bench.outputs);
        reinterpret_cast<std::uint8_t*>(&inputs)[random() % sizeof inputs] ^=
            static_cast<std::uint8_t>(1U << random() % 8);
      } else {
        auto* bytes = reinterpret_cast<std::uint8_t*>(&inputs);
        for (std::size_t i = kind == 1 ? 8 : 0; i < sizeof inputs; ++i) bytes[i] = static_cast<std::uint8_t>(random());
        if (kind != 3) inputs.now_us = bench.plant.inputs().now_us + 250U * static_cast<unsigned>(step + 1);
      }
      bench.core.Step(inputs, bench.outputs);
      bench.Fetch();
      bench.SendCommand();
      ASSERT_FALSE(duty.IsUnsafe(bench.outputs, bench.core.state())) << life << " " << step;
      for (int k = 0; k < wire::kCoils; ++k) ASSERT_TRUE(IsFinite(bench.core.heat().temperature_C(k)));
    }
    EXPECT_EQ(bench.bad_frames, 0);
    EXPECT_EQ(bench.core.state(), State::kFault) << life;
  }
}

// Whatever coils a base is built with, it arms and holds its current.
TEST(FirmwareFuzz, RandomCoilParametersHoldTheirCurrent) {
  std::mt19937_64 random(4);
  for (int base = 0; base < 40; ++base) {
    Settings settings;
    for (CoilSettings& coil : settings.coils) {
      coil.resistance_20C_ohm = std::uniform_real_distribution<float>(0.4F, 1.2F)(random);
      coil.inductance_H = coil.resistance_20C_ohm * std::uniform_real_distribution<float>(0.9e-3F, 3e-3F)(random);
    }
    FirmwarePlant::Options options;
    options.seed = random();
    options.supply_V = std::uniform_real_distribution<double>(12, 24)(random);
    options.resistance_error = std::uniform_real_distribution<double>(-0.03, 0.03)(random);
    options.inductance_error = std::uniform_real_distribution<double>(-0.1, 0.1)(random);
    FirmwareBench bench(settings, options);
    ASSERT_TRUE(bench.RunToArmed()) << base;
    double largest_A = 0;
    bench.SetAll(8);
    bench.each_step = [&] { largest_A = std::max(largest_A, bench.plant.largest_A()); };
    bench.RunMs(100);
    EXPECT_LT(largest_A, 8 * 1.05) << base;
    for (int k = 0; k < wire::kCoils; ++k) EXPECT_NEAR(bench.plant.current_A(k), 8, 0.04) << base;
    EXPECT_EQ(bench.core.faults(), 0U) << base;
  }
}

}  // namespace test_firmware_fuzz
}  // namespace omni::firmware
