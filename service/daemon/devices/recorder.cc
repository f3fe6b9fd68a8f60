#include "service/daemon/devices/recorder.h"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>

#include <spdlog/spdlog.h>

#include "service/base/files/whole_file.h"

namespace omni::daemon {
namespace {

constexpr const char* kHeader =
    "tick,t_ns,done_ns,late,status,magnet_x_m,magnet_y_m,magnet_z_m,axis_x,axis_y,axis_z,tip_x_m,tip_y_m,tip_z_m,"
    "force_x_N,force_y_N,force_z_N,current_x_A,current_y_A,current_z_A,contact,gap_m,gate,select,tip_force,thumb_x,"
    "thumb_y,haptic_pulses,faults,car,car_x_m,car_y_m,car_heading_rad,car_hits,car_laps,car_last_lap_s,sigma_m\n";

float Value(const base::InputState& inputs, base::InputComponent component) {
  return inputs.components[static_cast<std::size_t>(component)].value;
}

int WriteLine(std::FILE* file, const loop::TickRecord& record) {
  const loop::TickOutput& o = record.output;
  const base::Vec3& p = o.tool.position_base_m;
  const base::Vec3& u = o.tool.axis_base;
  const base::Vec3& d = o.tool.device_point_base_m;
  const base::Vec3& f = o.wrench.force_N;
  const auto& i = o.currents.current_A;
  const auto& C = o.tool.covariance;
  const haptics::VehicleReport& race = o.haptics.vehicle;
  return std::fprintf(
      file,
      "%llu,%lld,%lld,%d,%d,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.7g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%d,%.6g,"
      "%.4g,%g,%.5g,%.5g,%.5g,%llu,%u,%d,%.7g,%.7g,%.6g,%u,%u,%.6g,%.4g\n",
      static_cast<unsigned long long>(o.tick), static_cast<long long>(record.scan.t_ns),
      static_cast<long long>(record.done_ns), record.late ? 1 : 0, static_cast<int>(o.tool.status), p.x, p.y, p.z, u.x,
      u.y, u.z, d.x, d.y, d.z, f.x, f.y, f.z, i[0], i[1], i[2], o.haptics.in_contact ? 1 : 0, o.tool.gap_m, o.gate,
      static_cast<double>(Value(o.inputs, base::InputComponent::kSelect)),
      static_cast<double>(Value(o.inputs, base::InputComponent::kTipForce)),
      static_cast<double>(Value(o.inputs, base::InputComponent::kThumbstickX)),
      static_cast<double>(Value(o.inputs, base::InputComponent::kThumbstickY)),
      static_cast<unsigned long long>(o.haptic_pulses), o.faults, race.on ? 1 : 0, race.position_base_m.x,
      race.position_base_m.y, race.heading_rad, race.hits, race.laps, race.last_lap_s, std::sqrt(C[0] + C[6] + C[12]));
}

}  // namespace

base::Result<std::unique_ptr<Recorder>> Recorder::Open(const std::string& path, loop::TelemetryRing& ring) {
  base::Result<base::UniqueFd> made = base::MakeNewFile(path);
  if (!made.ok()) return base::Error{made.error()};
  std::FILE* file = ::fdopen(made->get(), "w");
  if (file == nullptr) return base::Error{base::WriteProblem(path, errno)};
  made->Release();
  std::fputs(kHeader, file);
  return std::unique_ptr<Recorder>(new Recorder(file, path, ring));
}

Recorder::Recorder(std::FILE* file, std::string path, loop::TelemetryRing& ring)
    : file_(file), path_(std::move(path)), ring_(ring), thread_([this] { Run(); }) {}

Recorder::~Recorder() {
  stop_.store(true, std::memory_order_release);
  thread_.join();
  std::fclose(file_);
}

void Recorder::Run() {
  while (!stop_.load(std::memory_order_acquire)) {
    Drain();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  Drain();
}

void Recorder::Drain() {
  loop::TickRecord record;
  while (ring_.TryPop(record)) {
    if (failed()) continue;  // keep the ring empty
    if (WriteLine(file_, record) < 0) {
      failed_.store(true, std::memory_order_relaxed);
      spdlog::error("recording {}: {}; the recording ends here, the service continues", path_, std::strerror(errno));
      continue;
    }
    lines_.fetch_add(1, std::memory_order_relaxed);
  }
  if (!failed() && std::fflush(file_) != 0) {
    failed_.store(true, std::memory_order_relaxed);
    spdlog::error("recording {}: {}; the recording ends here, the service continues", path_, std::strerror(errno));
  }
}

}  // namespace omni::daemon
