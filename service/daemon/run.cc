#include "service/daemon/run.h"

#include <csignal>
#include <ctime>
#include <exception>
#include <filesystem>
#include <memory>
#include <optional>
#include <random>
#include <vector>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/paths.h"
#include "service/daemon/publish.h"
#include "service/daemon/recorder.h"
#include "service/daemon/service.h"
#include "service/daemon/transport_tick_source.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin.h"

namespace omni::daemon {
namespace {

constexpr timespec kPoll{.tv_sec = 0, .tv_nsec = 100'000'000};
constexpr int kReopenPolls = 10;  // one second between attempts to open a device

// Blocks the signals that end the service; every thread started later inherits this.
sigset_t BlockEndSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return set;
}

bool EndAsked(const sigset_t& set) { return sigtimedwait(&set, nullptr, &kPoll) > 0; }

base::Result<std::unique_ptr<device::Transport>> OpenTwin(const RunOptions& options) {
  std::error_code error;
  const std::filesystem::path self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "omni").string();
  std::vector<std::string> arguments{"--seed", std::to_string(options.twin_seed)};
  const auto add = [&](const char* name, const std::string& value) {
    if (!value.empty()) arguments.insert(arguments.end(), {name, value});
  };
  add("--script", options.twin_script);
  add("--record", options.twin_record);
  add("--device", options.device_file);
  return sim::SpawnTwin(program, arguments);
}

// One opened device with its loop; destroyed in reverse order.
struct DeviceSession {
  DeviceSession(std::unique_ptr<device::Transport> opened, const loop::TickConfig& config, const RunOptions& options,
                loop::TickSink& sink)
      : transport(std::move(opened)),
        source(*transport),
        loop(config, {.realtime = options.realtime, .telemetry = !options.record_path.empty()}, source, sink) {}

  std::unique_ptr<device::Transport> transport;
  TransportTickSource source;
  loop::TickThread loop;
  std::unique_ptr<Recorder> recorder;
};

std::unique_ptr<DeviceSession> OpenDevice(const RunOptions& options, const loop::TickConfig& config,
                                          loop::TickSink& sink, Service& service) {
  auto transport = OpenTwin(options);
  if (!transport.ok()) {
    service.Detach(transport.error());
    spdlog::error("device: {}", transport.error());
    return nullptr;
  }
  auto session = std::make_unique<DeviceSession>(std::move(*transport), config, options, sink);
  if (!options.record_path.empty()) {
    auto recorder = Recorder::Open(options.record_path, session->loop.telemetry());
    if (recorder.ok()) {
      session->recorder = std::move(*recorder);
    } else {
      spdlog::error("{}", recorder.error());
    }
  }
  session->loop.Start();
  service.Attach(session->loop, *session->transport);
  const std::string& refused = session->loop.realtime().reason;
  if (options.realtime && !refused.empty()) spdlog::warn("real-time: {}", refused);
  const device::TransportInfo& info = session->transport->info();
  spdlog::info("device: {}{}", info.name, info.simulation ? " (simulation)" : "");
  return session;
}

void CloseDevice(std::unique_ptr<DeviceSession>& session, Service& service, const std::string& why) {
  if (session == nullptr) return;
  service.Detach(why);
  session.reset();
}

void ServeUntilSignal(const RunOptions& options, const loop::TickConfig& config, loop::TickSink& sink, Service& service,
                      const sigset_t& end_signals) {
  std::unique_ptr<DeviceSession> session = OpenDevice(options, config, sink, service);
  int polls = 0;
  while (!EndAsked(end_signals)) {
    if (session != nullptr && session->loop.finished()) {
      spdlog::error("device: lost; trying again every second");
      CloseDevice(session, service, "lost");
      polls = 0;
    }
    if (session == nullptr && ++polls % kReopenPolls == 0) session = OpenDevice(options, config, sink, service);
  }
  CloseDevice(session, service, "the service is ending");
}

// The twin's imperfections follow from its seed: it is another base with every seed.
std::string SerialOf(const RunOptions& options) { return "twin-" + std::to_string(options.twin_seed); }

// A calibration that cannot be used leaves the base as drawn: less precise, and everybody is told.
config::CalibrationChoice Choose(const RunOptions& options, const base::DeviceGeometry& device) {
  config::CalibrationChoice choice = config::ChooseCalibration(options.calibration_path, device, SerialOf(options));
  if (!choice.problem.empty()) spdlog::error("calibration: {}", choice.problem);
  if (choice.file) spdlog::info("calibration: {} of {}", choice.path, choice.file->date);
  if (choice.path.empty()) spdlog::info("calibration: none; omni calibrate makes one");
  return choice;
}

loop::TickConfig MakeConfig(const base::DeviceGeometry& device, const config::CalibrationChoice& choice) {
  return choice.file ? loop::MakeTickConfig(device, choice.file->calibration) : loop::MakeTickConfig(device);
}

std::uint64_t RandomInstance() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

int RunChecked(const RunOptions& options) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("omnid"));
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  const sigset_t end_signals = BlockEndSignals();
  std::optional<base::DeviceGeometry> from_file;
  if (!options.device_file.empty()) {
    auto loaded = config::LoadDeviceFile(options.device_file);
    if (!loaded.ok()) {
      spdlog::error("{}", loaded.error());
      return 1;
    }
    from_file = *loaded;
  }
  const base::DeviceGeometry& device = from_file ? *from_file : config::DefaultDevice();
  const config::CalibrationChoice calibration = Choose(options, device);
  const std::uint64_t instance = RandomInstance();
  auto publisher = ipc::StatePublisher::Create(instance);
  if (!publisher.ok()) {
    spdlog::error("{}", publisher.error());
    return 1;
  }
  PublishSink sink(**publisher);
  Service service({.version = OMNI_VERSION,
                   .instance = instance,
                   .apps = config::LoadAppTable(config::AppFolders(), config::ScenesFolder()),
                   .hull_radius_m = device.hull_radius_m,
                   .calibration = calibration});
  auto server = ipc::Server::Open(
      {.socket_path = options.socket_path, .service_instance = instance, .state_fd = (*publisher)->fd()}, service);
  if (!server.ok()) {
    spdlog::error("{}", server.error());
    return 1;
  }
  service.SetServer(server->get());
  (*server)->Start();
  spdlog::info("omnid {} listens on {}", OMNI_VERSION, (*server)->socket_path());
  ServeUntilSignal(options, MakeConfig(device, calibration), sink, service, end_signals);
  (*server)->Stop();
  return 0;
}

}  // namespace

int Run(const RunOptions& options) {
  try {
    return RunChecked(options);
  } catch (const std::exception& caught) {
    spdlog::critical("omnid: {}", caught.what());
    return 1;
  }
}

}  // namespace omni::daemon
