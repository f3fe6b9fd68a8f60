#include "service/daemon/devices/device_keeper.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/clock.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/twin_file.h"
#include "service/config/paths.h"
#include "service/config/text/text_file.h"
#include "service/daemon/clients/force_clients.h"
#include "service/daemon/devices/attached_device.h"
#include "service/daemon/devices/fault_log.h"
#include "service/daemon/devices/host_watch.h"
#include "service/daemon/devices/recorder.h"
#include "service/daemon/run.h"
#include "service/magnetics/nominal.h"
#include "service/room/fit_watch.h"
#include "service/room/room_watch.h"

namespace omni::daemon {
namespace {

constexpr int kReopenPolls = 10;  // one second between attempts to open a device

// `share`: of the ticks, late or missed.
std::string StarvedText(double share) {
  char percent[16];
  std::snprintf(percent, sizeof percent, "%.1f %%", 100 * share);
  return std::string(percent) +
         " of the ticks are late or missed: this computer does not keep up with the base; close what keeps its "
         "processor busy, and allow real-time scheduling (docs/howto/realtime.md)";
}

// `path`: of the calibration in use; empty: none, and `never` was there one. `share`: of the time, without an
// explanation.
std::string MisfitText(const std::string& path, bool never, double share) {
  const std::string percent = std::to_string(std::lround(100 * share));
  if (path.empty()) {
    const std::string why = never ? "this base was never calibrated" : "this base's calibration is not used";
    return why + ", and its nominal geometry does not fit: " + percent +
           " % of the time no pose explains the sensors' readings, so there is no force; measure it: omni calibrate";
  }
  return path + " does not fit this base: a magnet is near, and " + percent +
         " % of the time no pose explains the sensors' readings, so there is no force; take other magnets and steel "
         "away; if that does not help, measure this base again: omni calibrate --replace, or restore the previous "
         "file: omni calibrate --restore";
}

// Logs those `findings` that are not among `others`.
void LogNew(const std::vector<room::RoomFinding>& findings, const std::vector<room::RoomFinding>& others,
            spdlog::level::level_enum level, const char* before) {
  for (const room::RoomFinding& finding : findings) {
    const auto same = [&](const room::RoomFinding& o) {
      return o.kind == finding.kind && o.sensors == finding.sensors;
    };
    if (std::none_of(others.begin(), others.end(), same)) spdlog::log(level, "room: {}{}", before, RoomText(finding));
  }
}

}  // namespace

// One opened device with its loop; destroyed in reverse order.
struct DeviceKeeper::Session {
  Session(OpenedDevice device, const loop::TickConfig& config, const base::Calibration* calibration,
          const RunOptions& options, loop::TickSink& sink)
      : opened(std::move(device)),
        room(calibration),
        source(*opened.transport),
        loop(config, {.realtime = WantsRealtime(options), .telemetry = !options.record_path.empty()}, source, sink) {}

  // A loop that never waits would starve the rest of the machine.
  bool WantsRealtime(const RunOptions& options) const {
    return options.realtime && !opened.transport->info().virtual_time;
  }

  OpenedDevice opened;
  room::RoomWatch room;
  TransportTickSource source;
  loop::TickThread loop;
  std::unique_ptr<Recorder> recorder;
  FaultLog faults;
  room::FitWatch fit;
  HostWatch host;
  bool misfit_reported = false;
  bool recording_failed = false;  // and logged
};

DeviceKeeper::DeviceKeeper(const RunOptions& options, const base::DeviceGeometry& device, loop::TickSink& sink,
                           AttachedDevice& attached, EndWatch& end)
    : options_(options),
      device_(device),
      sink_(sink),
      attached_(attached),
      end_(end),
      magnets_(config::UserMagnetsFile(), config::WriteTextFile) {}

DeviceKeeper::~DeviceKeeper() { Close("the service is ending"); }

bool DeviceKeeper::Open() {
  const RunOptions options = WithFreeNames(options_);
  auto opened = OpenDevice(options);
  if (!opened.ok()) {
    attached_.Detach(opened.error());
    const char* next = IsReplay(options_.device) ? "" : "; omnid tries again every second";
    if (opened.error() != reported_) spdlog::error("device: {}{}", opened.error(), next);
    reported_ = opened.error();
    return false;
  }
  reported_.clear();
  if (opened->transport->info().simulation && !IsTwin(options_.device)) spdlog::warn("SIMULATION: {}", kSimulationText);
  if (const std::string problem = SensorProblem(opened->transport->info(), device_); !problem.empty())
    spdlog::warn("device: {}", problem);
  loop::TickConfig config = Calibrated(opened->serial);
  magnets_.LoadKnownMagnets(opened->serial, calibration_ ? calibration_->moment_Am2 : 0, config.tracker.magnets);
  Record(options, *opened);
  session_ =
      std::make_unique<Session>(std::move(*opened), config, calibration_ ? &*calibration_ : nullptr, options_, sink_);
  if (!options.record_path.empty()) {
    auto recorder = Recorder::Open(options.record_path, session_->loop.telemetry());
    if (recorder.ok()) {
      session_->recorder = std::move(*recorder);
      end_.SetRecording(true);
    } else {
      spdlog::error("{}", recorder.error());
    }
  }
  SetRoom();
  const protocol::ForceProperties properties = DescribeForce(config, device_);
  attached_.With([&](auto& state) { state.force_properties = properties; });
  session_->loop.Start();
  attached_.Attach(session_->loop, *session_->opened.transport);
  const std::string& refused = session_->loop.realtime().reason;
  if (session_->WantsRealtime(options_) && !refused.empty()) spdlog::warn("real-time: {}", refused);
  spdlog::info("device: {} (serial {})", session_->opened.transport->info().name, session_->opened.serial);
  return true;
}

// Without a usable calibration the base uses its nominal geometry: less precise, and this is reported.
loop::TickConfig DeviceKeeper::Calibrated(const std::string& serial) {
  const config::CalibrationChoice choice = config::ChooseCalibration(
      options_.calibration_path,
      {.device = device_, .drawing = magnetics::NominalCalibration(device_), .serial = serial},
      IsTwin(options_.device) ? config::ShippedCalibration(options_.twin, options_.twin_seed) : std::string());
  if (!choice.problem.empty()) spdlog::error("calibration: {}", choice.problem);
  if (!choice.note.empty()) spdlog::warn("calibration: {}: {}", choice.path, choice.note);
  if (choice.file) {
    spdlog::info("calibration: {}{} of {}", choice.shipped ? "shipped with the twin, " : "", choice.path,
                 choice.file->date);
  }
  if (choice.path.empty()) {
    spdlog::info("calibration: never calibrated; measure this base: omni calibrate{}",
                 IsTwin(options_.device) ? " --device twin, with the same --twin and --seed" : "");
  }
  attached_.SetCalibration(choice);
  never_calibrated_ = choice.path.empty();
  calibration_path_ = choice.file ? choice.path : std::string();
  calibration_ = choice.file ? std::optional(choice.file->calibration) : std::nullopt;
  return choice.file ? loop::MakeTickConfig(device_, choice.file->calibration) : loop::MakeTickConfig(device_);
}

void DeviceKeeper::WatchRoom() {
  room::RoomWatch& room = session_->room;
  const std::vector<room::RoomFinding> before = room.findings();
  const tracker::RoomSample& sample = session_->loop.room().Read();
  magnets_.AddSample(sample.tool, static_cast<std::int64_t>(std::time(nullptr)));
  const bool stored = magnets_.HandleWritten();
  const bool news = room.Add(sample);
  if (room.field()) attached_.With([&](auto& state) { state.field = *room.field(); });
  if (!news && !stored) return;
  LogNew(room.findings(), before, spdlog::level::warn, "");
  LogNew(before, room.findings(), spdlog::level::info, "no longer: ");
  SetRoom();
}

void DeviceKeeper::SetRoom() {
  std::vector<room::RoomFinding> findings = session_->room.findings();
  if (magnets_.problem()) findings.push_back(*magnets_.problem());
  attached_.With([&](auto& state) { state.room = std::move(findings); });
}

void DeviceKeeper::WatchFit() {
  const loop::FitStatistics& fit = session_->loop.statistics().fit;
  session_->fit.Update(fit.explained.load(), fit.contradicted.load(), base::MonotonicNow_ns());
  const bool misfit = session_->fit.misfit() && !session_->room.explains_misfit();
  if (misfit == session_->misfit_reported) return;
  session_->misfit_reported = misfit;
  const std::string text =
      misfit ? MisfitText(calibration_path_, never_calibrated_, session_->fit.share()) : std::string();
  attached_.With([&](auto& state) { state.misfit = text; });
  if (misfit) {
    spdlog::error("calibration: {}", text);
  } else if (!session_->fit.misfit()) {
    spdlog::info("calibration: fits again, poses explain the sensors' readings");
  }
}

void DeviceKeeper::WatchHost() {
  const loop::TickStatistics& ticks = session_->loop.statistics();
  HostWatch& host = session_->host;
  const std::uint64_t superseded = session_->opened.transport->counters().superseded;
  if (!host.Update(ticks.ticks.load(), ticks.late.load(), superseded, base::MonotonicNow_ns())) return;
  if (!host.starved()) {
    attached_.With([](auto& state) { state.starved.clear(); });
    spdlog::info("host: keeps up again");
    return;
  }
  const std::string text = StarvedText(host.share());
  attached_.With([&](auto& state) { state.starved = text; });
  spdlog::warn("host: {}", text);
}

// The state first: the base sends the part of a fault before a state that shows it.
void DeviceKeeper::LogFaults() {
  device::Transport& transport = *session_->opened.transport;
  const device::TransportState state = transport.state();
  device::BaseNote note;
  for (std::size_t i = 0; i < device::BaseNotes::kCapacity && transport.PopNote(note); ++i) {
    session_->faults.AddNote(note, base::MonotonicNow_ns());
  }
  for (const FaultLine& line : session_->faults.PopLines(state)) {
    spdlog::log(line.is_problem ? spdlog::level::err : spdlog::level::info, "device: {}", line.text);
  }
}

void DeviceKeeper::Record(const RunOptions& options, OpenedDevice& opened) {
  if (opened.replay != nullptr && !opened.replay->summary().cut.empty()) {
    spdlog::warn("replay: {}", opened.replay->summary().cut);
  }
  if (options.record_device_path.empty()) return;
  const std::string problem = RecordDevice(options, device_.current_max_A, opened);
  if (!problem.empty()) spdlog::error("{}", problem);
  end_.SetRecording(problem.empty());
}

void DeviceKeeper::WatchRecording() {
  if (session_ == nullptr || session_->opened.recording == nullptr || session_->recording_failed) return;
  const std::string problem = session_->opened.recording->recorder().problem();
  if (problem.empty()) return;
  session_->recording_failed = true;
  spdlog::error("{}", problem);
}

bool DeviceKeeper::Poll() {
  WatchRecording();
  if (session_ != nullptr) LogFaults();
  if (session_ != nullptr) WatchRoom();
  if (session_ != nullptr) WatchFit();
  if (session_ != nullptr) WatchHost();
  if (session_ != nullptr && session_->loop.finished()) {
    if (session_->loop.end_status() == loop::WaitStatus::kEnd) {
      Close("the recording is over");
      return false;
    }
    spdlog::error("device: lost; omnid tries to open it again every second");
    Close("lost");
    polls_ = 0;
  }
  if (session_ == nullptr && ++polls_ % kReopenPolls == 0) Open();
  return true;
}

void DeviceKeeper::Close(const std::string& why) {
  if (session_ == nullptr) return;
  attached_.Detach(why);  // the loop has ended: no thread reads or writes any more
  if (session_->opened.replay != nullptr) {
    const device::ReplayComparison commands = session_->opened.replay->comparison();
    spdlog::info("replay: {} scans; commands: {} as recorded, {} others (by at most {:.3g} A), {} extra, {} missing",
                 session_->opened.replay->counters().received, commands.same, commands.different,
                 commands.largest_difference_A, commands.extra, commands.missing);
  }
  if (session_->opened.recording != nullptr) {
    device::DeviceRecorder& recorder = session_->opened.recording->recorder();
    recorder.Close();
    WatchRecording();
    spdlog::info("recorded: {}: {} scans and commands, {} lost", recorder.path(), recorder.written(), recorder.lost());
  }
  session_->recorder.reset();
  end_.SetRecording(false);
  session_.reset();
}

}  // namespace omni::daemon
