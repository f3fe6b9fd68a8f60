#include "service/daemon/run.h"

#include <csignal>
#include <exception>
#include <optional>
#include <random>
#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/threads/realtime_threads.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/follow_file.h"
#include "service/config/inputs/input_settings.h"
#include "service/config/paths.h"
#include "service/daemon/clients/publish.h"
#include "service/daemon/devices/device_keeper.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/end_watch.h"
#include "service/daemon/log_queue.h"
#include "service/daemon/scenes/child_builder.h"
#include "service/daemon/service.h"
#include "service/ipc/listener.h"
#include "service/loop/tick_config.h"

namespace omni::daemon {
namespace {

constexpr int kPoll_ms = 100;
constexpr double kExitIdle_s = 60;  // of an omnid that systemd has started for a client

// Until a signal comes, a replay is over, or no client has been there for options.exit_idle_s. False: there is nothing
// to replay.
bool ServeDevice(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink, Service& service,
                 EndWatch& end) {
  const EndWatch::CoilsToZero zero(end, [&service] { service.device().CoilsToZero(); });
  DeviceKeeper keeper(options, device, sink, service.device(), end);
  if (!keeper.Open() && IsReplay(options.device)) return false;
  while (!end.Wait(kPoll_ms) && keeper.Poll()) {
    if (options.exit_idle_s <= 0 || service.Idle_s() < options.exit_idle_s) continue;
    spdlog::info("no client for {} s: omnid ends", options.exit_idle_s);
    break;
  }
  return true;
}

// The control thread ends the force of an application that has gone: only the tick goes before it. Refused: the loop's
// own request says so.
void RequestControlPriority(const RunOptions& options) {
  static thread_local const base::RealtimeThread named("omni-control");  // until the thread ends
  if (options.realtime) static_cast<void>(loop::RequestFifo(loop::TickThread::Options{}.priority - 1));
}

std::uint64_t RandomInstance() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32) | random();
}

// What systemd has passed decides where the socket is, and that omnid ends when nobody needs it.
base::Status Adopt(const ipc::InheritedSocket& inherited, RunOptions& options) {
  if (!options.socket_path.empty() && options.socket_path != inherited.path) {
    return base::Error{"--socket " + options.socket_path + ": systemd has passed " + inherited.path +
                       "; leave the option out, or change ListenSequentialPacket= of omnid.socket"};
  }
  options.socket_path = inherited.path;
  if (options.exit_idle_s <= 0) options.exit_idle_s = kExitIdle_s;
  return base::Ok{};
}

int RunChecked(RunOptions options, std::optional<ipc::InheritedSocket> inherited) {
  if (inherited) {
    if (const base::Status adopted = Adopt(*inherited, options); !adopted.ok()) {
      spdlog::error("{}", adopted.error());
      return 1;
    }
  }
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
  const std::string hand = options.hand == "auto" ? inputs.hand : options.hand;
  const auto follow = config::LoadFollowFile(config::UserFollowFile());
  if (!follow.ok()) spdlog::warn("{}", follow.error());
  const std::string program =
      options.builder_program.empty() ? config::ProgramFolder() + "/omni-builder" : options.builder_program;
  const auto builder = std::make_shared<const ChildBuilder>(program);
  const base::Status startable = builder->CheckProgram();
  Service service(
      {.version = OMNI_VERSION,
       .instance = instance,
       .apps = std::move(apps),
       .inputs = std::move(inputs),
       .hull_radius_m = device.hull_radius_m,
       .tip_radius_m = config::NibRadius_m(device.magnet),
       .cache_folder = config::CacheFolder(),
       .hand = hand,
       .alignment_path = options.alignment_path.empty() ? config::UserAlignmentFile() : options.alignment_path,
       .journal_folder = config::UserSculptFolder(),
       .stop_path = options.stop_path.empty() ? config::UserStopFile() : options.stop_path,
       .build_way = builder,
       .builds_refused = startable.ok() ? std::string() : startable.error(),
       .base_follows = !follow.ok() || follow->has_value(),
       .on_aligned = [&sink](bool aligned) { sink.SetAligned(aligned); },
       .on_base = [&publisher](const protocol::BaseSample& sample) { (*publisher)->PublishBase(sample); }});
  auto server = ipc::Server::Open({.socket_path = options.socket_path,
                                   .inherited_fd = inherited ? inherited->fd.Release() : -1,
                                   .service_instance = instance,
                                   .state_fd = (*publisher)->fd(),
                                   .on_start = [&options] { RequestControlPriority(options); },
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
  base::LeaveRealtimeAtLimit();
  auto inherited = ipc::TakeInheritedSocket();  // before the first thread
  const LogQueue log(options.log_level);
  if (!inherited.ok()) {
    spdlog::error("{}", inherited.error());
    return 1;
  }
  try {
    return RunChecked(options, std::move(*inherited));
  } catch (const std::exception& caught) {
    spdlog::critical("omnid: {}", caught.what());
    return 1;
  }
}

}  // namespace omni::daemon
