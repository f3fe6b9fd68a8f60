// omni-bench latency: budget of the time between a sensor's sample and the current that responds to it. Sensors,
// control steps and coils are those of the digital twin (a simulation, with the firmware's control core); the tick is
// timed on this machine; buses are calculated, because no board has been measured.
#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/base/limits.h"
#include "service/config/files/device_file.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/stability/stability.h"
#include "service/loop/realtime.h"
#include "service/loop/tick.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/support/hand/free_motion.h"

namespace omni::bench {
namespace {

constexpr int kWavedTicks = 20'000;
constexpr double kLateQuantile = 0.99;
constexpr double kStep_us = 1e6 * base::kTickPeriod_s / base::kStepsPerTick;
// Eight magnetometers of 8 bytes each and a command byte at 10 MHz, with the pauses that the chips require: the time in
// firmware/board/teensy40/sensors/hall_array.h, calculated.
constexpr double kBus_us = 90;
// USB 2.0 high speed: a bulk transfer waits for its microframe [5.10], and its bytes pass at 480 Mbit/s.
constexpr double kMicroframe_us = 125, kBytesPerMicrosecond = 60, kPacketOverhead = 55;

struct Stage {
  double mean_us = 0, late_us = 0;
};

Stage StageOf(const std::vector<double>& us) { return {tools::Mean(us), tools::Quantile(us, kLateQuantile)}; }
// Anything up to `longest_us`, all equally likely.
Stage Evenly(double longest_us) { return {longest_us / 2, kLateQuantile * longest_us}; }
Stage Later(const Stage& stage, double by_us) { return {stage.mean_us + by_us, stage.late_us + by_us}; }

Stage Usb(std::size_t bytes) {
  return Later(Evenly(kMicroframe_us), (static_cast<double>(bytes) + kPacketOverhead) / kBytesPerMicrosecond);
}

struct Waved {
  Stage sample, stamp, tick;
  double response_us = 0;  // late, from the stamp to the control step, as the base reports; a host without delay
};

// A pen that is waved about, and the loop with its gate open on it.
Waved RunLoop(const base::DeviceGeometry& device, std::uint64_t seed) {
  using Clock = std::chrono::steady_clock;
  sim::PlantOptions options;
  options.seed = seed;
  options.motion = std::make_shared<sim::FreeMotion>(device, sim::MotionOptions{.seed = seed},
                                                     (kWavedTicks + 1) * base::kTickPeriod_s);
  sim::Loopback twin(device, options);
  const loop::TickConfig config = loop::MakeTickConfig(device);
  const haptics::Scene scene;
  const auto state = std::make_unique<loop::LoopState>();
  const auto output = std::make_unique<loop::TickOutput>();
  std::vector<double> sample_us, stamp_us, tick_us;
  base::HallScan scan;
  for (int i = 0; i < kWavedTicks; ++i) {
    twin.Tick(scan);
    const loop::Commands commands{
        .t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
    const Clock::time_point begin = Clock::now();
    loop::Tick(config, scan, commands, scene, *state, *output);
    tick_us.push_back(std::chrono::duration<double, std::micro>(Clock::now() - begin).count());
    twin.Write(output->currents);
    stamp_us.push_back(1e-3 * static_cast<double>(scan.tick_lead_ns));
    for (const std::int64_t age_ns : scan.age_ns) {
      sample_us.push_back(1e-3 * static_cast<double>(age_ns + scan.tick_lead_ns));
    }
  }
  return {StageOf(sample_us), StageOf(stamp_us), StageOf(tick_us), 1e-3 * static_cast<double>(scan.response_ns)};
}

// From the control step that acts on a step of `amplitude_A` until 63 % of it flow, on straight lines between the ends
// of control steps; 0: never within 50 ms.
double CoilLag_us(const base::DeviceGeometry& device, std::uint64_t seed, double amplitude_A) {
  sim::PlantOptions options;
  options.seed = seed;
  sim::Loopback twin(device, options);
  base::HallScan scan;
  for (int i = 0; i < 300; ++i) {
    twin.Tick(scan);
    twin.Write({{0, 0, 0}});
  }
  const double wanted_A = (1 - std::exp(-1.0)) * amplitude_A;
  double before_A = scan.step_current_A.back()[1], t_us = -kStep_us;  // inputs are read at the step's begin
  for (int tick = 0; tick < 50; ++tick) {
    twin.Write({{0, amplitude_A, 0}});
    twin.Tick(scan);
    for (const auto& step_A : scan.step_current_A) {
      if (step_A[1] >= wanted_A) return t_us + kStep_us * (wanted_A - before_A) / (step_A[1] - before_A);
      before_A = step_A[1];
      t_us += kStep_us;
    }
  }
  return 0;
}

nlohmann::ordered_json Row(const char* stage, const Stage& took, const char* what) {
  return {{"stage", stage}, {"mean_us", took.mean_us}, {"late_us", took.late_us}, {"what", what}};
}

nlohmann::ordered_json RuleRow(const char* what, double delay_us) {
  const haptics::Config config;
  const haptics::Input quiet{.delay_s = 1e-6 * delay_us};
  const double predict_s = haptics::BestPrediction_s(config, quiet);
  return {{"table", "stiffness"},
          {"delay", what},
          {"delay_us", delay_us},
          {"unpredicted_N_m", haptics::StiffnessLimit(config, quiet, quiet.noise, 0)},
          {"predicted_N_m", haptics::StiffnessLimit(config, quiet, quiet.noise, predict_s)}};
}

}  // namespace

base::Result<BenchRows> BenchLatency(const BenchOptions& options) {
  loop::FlushDenormals();
  const base::DeviceGeometry& device = config::DefaultDevice();
  const Waved measured = RunLoop(device, options.seed);
  const double coil_us = CoilLag_us(device, options.seed, 1), large_us = CoilLag_us(device, options.seed, 5);
  const Stage usb_in = Usb(wire::FrameSize<wire::Telemetry>()), usb_out = Usb(wire::FrameSize<wire::Command>());
  const Stage step = Evenly(kStep_us);
  Stage sum;
  for (const Stage& stage : {measured.stamp, Stage{kBus_us, kBus_us}, usb_in, measured.tick, usb_out, step}) {
    sum.mean_us += stage.mean_us;
    sum.late_us += stage.late_us;
  }
  BenchRows rows{
      Row("sensor", measured.sample, "any sample to the tick's end, twin; the tracker takes each at its own instant"),
      Row("stamp", measured.stamp, "newest sample to the tick's end, twin"),
      Row("bus", {kBus_us, kBus_us}, "eight sensors over SPI, calculated"),
      Row("usb in", usb_in, "TELEMETRY, high speed, calculated"),
      Row("tick", measured.tick, "service's tick, this machine"),
      Row("usb out", usb_out, "COMMAND, high speed, calculated"),
      Row("step", step, "until the next control step"),
      Row("response", sum, "stamp to control step: the sum; late: all late at once"),
      Row("coil", {coil_us, large_us}, "control step to 63 % of 1 A; late: of 5 A; twin"),
  };
  rows.push_back(RuleRow("nothing measured", 1e6 * haptics::Config{}.delay_s));
  rows.push_back(RuleRow("the budget's response, late", sum.late_us));
  rows.push_back(RuleRow("the twin's own, in virtual time", measured.response_us));
  return rows;
}

}  // namespace omni::bench
