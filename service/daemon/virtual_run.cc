#include "service/daemon/virtual_run.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>

#include "service/haptics/sculpt/sculpted_scene.h"
#include "service/loop/realtime.h"

namespace omni::daemon {

template <class T>
void TickHash::Bits(const T& value) noexcept {
  unsigned char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  for (const unsigned char byte : bytes) hash_ = (hash_ ^ byte) * 1099511628211ULL;
}

void TickHash::Vector(const base::Vec3& v) noexcept {
  Bits(v.x);
  Bits(v.y);
  Bits(v.z);
}

void TickHash::Add(const base::HallScan& scan, const loop::TickOutput& output) noexcept {
  Bits(scan.t_ns);
  for (const base::Vec3& field : scan.field_sensor_T) Vector(field);
  for (const double current_A : scan.coil_current_A) Bits(current_A);
  for (const double temperature_C : scan.coil_temperature_C) Bits(temperature_C);
  Bits(scan.saturated_mask);
  Bits(static_cast<int>(output.tool.status));
  Vector(output.tool.position_base_m);
  Vector(output.tool.axis_base);
  Vector(output.tool.velocity_base_m_s);
  Vector(output.tool.device_point_base_m);
  for (int i = 0; i < output.haptics.contact_count; ++i) {
    Vector(output.haptics.contacts[static_cast<std::size_t>(i)].point_base_m);
  }
  Bits(output.gate);
  Vector(output.wrench.force_N);
  for (const double current_A : output.currents.current_A) Bits(current_A);
}

namespace {

loop::Commands OpenGate(const base::HallScan& scan) {
  return {.t_ns = scan.t_ns, .gate = loop::ForceGate::kOpen, .idle = false, .scene_generation = 1};
}

void Count(const loop::TickOutput& output, VirtualRunSummary& summary) {
  const double force_N = Norm(output.wrench.force_N);
  ++summary.ticks;
  summary.tracked_ticks += output.tool.status == base::TrackingStatus::kTracking ? 1 : 0;
  summary.contact_ticks += force_N > 0.010 ? 1 : 0;
  summary.peak_force_N = std::max(summary.peak_force_N, force_N);
  summary.select_presses =
      output.inputs.components[static_cast<std::size_t>(base::InputComponent::kSelect)].press_count;
}

}  // namespace

VirtualRunSummary RunVirtual(const loop::TickConfig& config, device::Transport& transport, const haptics::Scene& scene,
                             const CommandScript& script, const TickObserver& observer) {
  loop::FlushDenormals();
  auto state = std::make_unique<loop::LoopState>();
  auto output = std::make_unique<loop::TickOutput>();
  VirtualRunSummary summary;
  TickHash hash;
  base::HallScan scan;
  haptics::sculpt::VirtualEditor editor(scene);
  loop::EnterScene(scene, 1, *state);
  while (transport.Read(scan, 0) == device::ReadStatus::kScan) {
    const loop::Commands commands = script ? script(scan) : OpenGate(scan);
    loop::Tick(config, scan, commands, scene, *state, *output);
    transport.Write(output->currents);
    hash.Add(scan, *output);
    Count(*output, summary);
    if (observer) observer(scan, *output);
    editor.AfterTick();
  }
  summary.hash = hash.value();
  return summary;
}

}  // namespace omni::daemon
