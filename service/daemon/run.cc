#include "service/daemon/run.h"

#include <csignal>
#include <exception>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/inputs/input_settings.h"
#include "service/config/paths.h"
#include "service/daemon/clients/publish.h"
#include "service/daemon/devices/device_keeper.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/end_watch.h"
#include "service/daemon/log_queue.h"
#include "service/daemon/service.h"
#include "service/loop/tick_config.h"

namespace omni::daemon {
namespace {

constexpr int kPoll_ms = 100;

// Until a signal comes or a replay is over. False: there is nothing to replay.
bool ServeDevice(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink, Service& service,
                 EndWatch& end) {
  const EndWatch::CoilsToZero zero(end, [&service] { service.CoilsToZero(); });
  DeviceKeeper keeper(options, device, sink, service, end);
  if (!keeper.Open() && IsReplay(options.device)) return false;
  while (!end.Wait(kPoll_ms) && keeper.Watch()) {
  }
  return true;
}

std::uint64_t RandomInstance() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

int RunChecked(const RunOptions& options) {
  EndWatch end;  // before any other thread starts, which inherits the blocked signals
  if (IsTwin(options.device)) spdlog::warn("SIMULATION: {}", kSimulationText);
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
  const std::uint64_t instance = RandomInstance();
  auto publisher = ipc::StatePublisher::Create(instance);
  if (!publisher.ok()) {
    spdlog::error("{}", publisher.error());
    return 1;
  }
  PublishSink sink(**publisher);
  config::AppTable apps = config::LoadAppTable(config::AppFolders(), config::ScenesFolder());
  config::InputPlan inputs = config::PlanInputs(config::UserInputsFile(), apps);
  Service service(
      {.version = OMNI_VERSION,
       .instance = instance,
       .apps = std::move(apps),
       .inputs = std::move(inputs),
       .hull_radius_m = device.hull_radius_m,
       .cache_folder = config::CacheFolder(),
       .hand = options.hand,
       .alignment_path = options.alignment_path.empty() ? config::UserAlignmentFile() : options.alignment_path,
       .on_aligned = [&sink](bool aligned) { sink.SetAligned(aligned); }});
  auto server = ipc::Server::Open({.socket_path = options.socket_path,
                                   .service_instance = instance,
                                   .state_fd = (*publisher)->fd(),
                                   .log = [](const std::string& line) { spdlog::warn("{}", line); }},
                                  service);
  if (!server.ok()) {
    spdlog::error("{}", server.error());
    return 1;
  }
  service.SetServer(server->get());
  (*server)->Start();
  spdlog::info("omnid {} listens on {}", OMNI_VERSION, (*server)->socket_path());
  const bool served = ServeDevice(options, device, sink, service, end);
  (*server)->Stop();
  return served ? 0 : 1;
}

}  // namespace

int Run(const RunOptions& options) {
  std::signal(SIGPIPE, SIG_IGN);
  const LogQueue log(options.log_level);
  try {
    return RunChecked(options);
  } catch (const std::exception& caught) {
    spdlog::critical("omnid: {}", caught.what());
    return 1;
  }
}

}  // namespace omni::daemon
