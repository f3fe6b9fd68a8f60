#include "service/daemon/run.h"

#include <csignal>
#include <ctime>
#include <exception>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/config/calibration_file.h"
#include "service/config/device_file.h"
#include "service/config/input_settings.h"
#include "service/config/paths.h"
#include "service/daemon/device_keeper.h"
#include "service/daemon/log_queue.h"
#include "service/daemon/open_device.h"
#include "service/daemon/publish.h"
#include "service/daemon/service.h"
#include "service/loop/tick_config.h"

namespace omni::daemon {
namespace {

constexpr timespec kPoll{.tv_sec = 0, .tv_nsec = 100'000'000};

// Blocks the signals that end the service; every thread started later inherits this.
sigset_t BlockEndSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  return set;
}

bool EndAsked(const sigset_t& set) { return sigtimedwait(&set, nullptr, &kPoll) > 0; }

// Until a signal comes or a replay is over. False: there is nothing to replay.
bool ServeDevice(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink, Service& service,
                 const sigset_t& end_signals) {
  DeviceKeeper keeper(options, device, sink, service);
  if (!keeper.Open() && IsReplay(options.device)) return false;
  while (!EndAsked(end_signals) && keeper.Watch()) {
  }
  return true;
}

std::uint64_t RandomInstance() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

int RunChecked(const RunOptions& options) {
  const sigset_t end_signals = BlockEndSignals();
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
  const bool served = ServeDevice(options, device, sink, service, end_signals);
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
