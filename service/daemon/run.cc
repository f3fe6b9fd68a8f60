#include "service/daemon/run.h"

#include <csignal>
#include <ctime>
#include <exception>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/paths.h"
#include "service/daemon/fault_log.h"
#include "service/daemon/open_device.h"
#include "service/daemon/publish.h"
#include "service/daemon/recorder.h"
#include "service/daemon/service.h"
#include "service/daemon/transport_tick_source.h"
#include "service/loop/tick_config.h"

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

// A calibration that cannot be used leaves the base as drawn: less precise, and everybody is told.
config::CalibrationChoice Choose(const RunOptions& options, const base::DeviceGeometry& device,
                                 const std::string& serial) {
  config::CalibrationChoice choice = config::ChooseCalibration(options.calibration_path, device, serial);
  if (!choice.problem.empty()) spdlog::error("calibration: {}", choice.problem);
  if (choice.file) spdlog::info("calibration: {} of {}", choice.path, choice.file->date);
  if (choice.path.empty()) spdlog::info("calibration: none; omni calibrate makes one");
  return choice;
}

loop::TickConfig MakeConfig(const base::DeviceGeometry& device, const config::CalibrationChoice& choice) {
  return choice.file ? loop::MakeTickConfig(device, choice.file->calibration) : loop::MakeTickConfig(device);
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
  FaultLog faults;
};

// `told`: the last error, which is not told again every second.
std::unique_ptr<DeviceSession> OpenSession(const RunOptions& options, const base::DeviceGeometry& device,
                                           loop::TickSink& sink, Service& service, std::string& told) {
  auto opened = OpenDevice(options);
  if (!opened.ok()) {
    service.Detach(opened.error());
    if (opened.error() != told) spdlog::error("device: {}; trying again every second", opened.error());
    told = opened.error();
    return nullptr;
  }
  told.clear();
  const config::CalibrationChoice calibration = Choose(options, device, opened->serial);
  service.SetCalibration(calibration);
  auto session =
      std::make_unique<DeviceSession>(std::move(opened->transport), MakeConfig(device, calibration), options, sink);
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
  const std::string serial = info.simulation ? "(simulation)" : "(serial " + opened->serial + ")";
  spdlog::info("device: {} {}", info.name, serial);
  return session;
}

void CloseSession(std::unique_ptr<DeviceSession>& session, Service& service, const std::string& why) {
  if (session == nullptr) return;
  service.Detach(why);
  session.reset();
}

void TellFaults(DeviceSession& session) {
  for (const FaultLine& line : session.faults.News(session.transport->state())) {
    spdlog::log(line.is_problem ? spdlog::level::err : spdlog::level::info, "device: {}", line.text);
  }
}

void ServeUntilSignal(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink,
                      Service& service, const sigset_t& end_signals) {
  std::string told;
  std::unique_ptr<DeviceSession> session = OpenSession(options, device, sink, service, told);
  int polls = 0;
  while (!EndAsked(end_signals)) {
    if (session != nullptr) TellFaults(*session);
    if (session != nullptr && session->loop.finished()) {
      spdlog::error("device: lost; trying again every second");
      CloseSession(session, service, "lost");
      polls = 0;
    }
    if (session != nullptr || ++polls % kReopenPolls != 0) continue;
    session = OpenSession(options, device, sink, service, told);
  }
  CloseSession(session, service, "the service is ending");
}

std::uint64_t RandomInstance() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

int RunChecked(RunOptions options) {
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
  options.device = SettleDevice(options.device);
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
                   .hull_radius_m = device.hull_radius_m});
  auto server = ipc::Server::Open(
      {.socket_path = options.socket_path, .service_instance = instance, .state_fd = (*publisher)->fd()}, service);
  if (!server.ok()) {
    spdlog::error("{}", server.error());
    return 1;
  }
  service.SetServer(server->get());
  (*server)->Start();
  spdlog::info("omnid {} listens on {}", OMNI_VERSION, (*server)->socket_path());
  ServeUntilSignal(options, device, sink, service, end_signals);
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
