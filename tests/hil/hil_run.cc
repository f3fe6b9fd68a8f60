#include "tests/hil/hil_run.h"

#include <stdlib.h>
#include <sys/prctl.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "firmware/core/link/settings.h"
#include "service/sim/twin/recording.h"
#include "service/twin/socket_guide.h"
#include "tests/hil/chain.h"
#include "tests/hil/hil_board.h"
#include "tests/hil/scenario.h"
#include "tests/hil/time/host_process.h"
#include "tests/hil/time/idle_watch.h"
#include "tests/hil/time/pacer.h"
#include "tests/hil/time/virtual_clock.h"
#include "tests/hil/usb/usb_emulator.h"

namespace omni::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr unsigned long kTimerSlack_ns = 1000;  // the naps between two checks are short
// Of real time.
constexpr std::int64_t kPatience_us = 20'000'000;  // for a program that is permanently busy; a machine may swap
constexpr std::uint64_t kUnsettledMax = 2;         // ticks
constexpr std::int64_t kEndPatience_ns = 5'000'000'000;
constexpr int kStartPatience_ms = 10'000;

volatile std::sig_atomic_t stop_requested = 0;
void RequestStop(int) { stop_requested = 1; }

int Fail(const std::string& message) {
  std::fprintf(stderr, "omni_hil: %s\n", message.c_str());
  return 1;
}

// Removes a variable from the environment during its lifetime: an emulator started meanwhile is not preloaded.
class Without {
 public:
  explicit Without(const char* name) : name_(name) {
    const char* value = getenv(name);
    if (value != nullptr) value_ = value;
    unsetenv(name);
  }
  ~Without() {
    if (value_) setenv(name_, value_->c_str(), 1);
  }
  Without(const Without&) = delete;
  Without& operator=(const Without&) = delete;

 private:
  const char* name_;
  std::optional<std::string> value_;
};

Json ToJson(const LinkCounts& counts) {
  return {{"frames", counts.frames},       {"dropped", counts.dropped},       {"corrupted", counts.corrupted},
          {"truncated", counts.truncated}, {"duplicated", counts.duplicated}, {"reordered", counts.reordered}};
}

Json ToJson(const Reaction& reaction) {
  Json json{{"what", reaction.what},       {"t_s", reaction.t_s},       {"window_ms", reaction.window_ms},
            {"peak_A", reaction.peak_A},   {"hot_A", reaction.hot_A},   {"hottest_C", reaction.hottest_C},
            {"zero_ms", reaction.zero_ms}, {"faults", reaction.faults}, {"faults_seen", reaction.faults_seen},
            {"state", reaction.state}};
  json["fault_ms"] = reaction.fault_ms ? Json(*reaction.fault_ms) : Json(nullptr);
  json["back_ms"] = reaction.back_ms ? Json(*reaction.back_ms) : Json(nullptr);
  return json;
}

class Run {
 public:
  // `guide` may be null: the hand plays its script.
  Run(const HilOptions& options, std::vector<HostProcess>& programs, sim::Plant& plant, Chain& chain, UsbEmulator& usb,
      VirtualClock& clock, std::unique_ptr<sim::HandGuide> guide)
      : options_(options),
        programs_(programs),
        clock_(clock),
        guide_(std::move(guide)),
        rig_{plant, usb, programs.front(), chain},
        scenario_(FindScenario(options.scenario), options.contact_timeout_s) {}

  base::Status Go(sim::Recording* recording) {
    base::Status went = base::Ok{};
    while (went && stop_requested == 0 && !scenario_.ended() && !OutOfTime() && !HostEnded()) went = Tick(recording);
    if (went) went = End(recording);
    return went;
  }

  Json Summary(int host_status, const std::string& problem) const {
    const double device_s = static_cast<double>(rig_.plant.now_ns()) * 1e-9;
    const double wall_s = static_cast<double>(base::MonotonicNow_ns() - started_ns_) * 1e-9;
    const ChainCounts& chain = rig_.chain.counts();
    const UsbCounts usb = rig_.usb.counts();
    const wire::Telemetry& telemetry = rig_.chain.telemetry();
    Json json{{"board", options_.board},
              {"paced", options_.paced},
              {"scenario", options_.scenario},
              {"problem", problem},
              {"host_status", host_status},
              {"device_s", device_s},
              {"wall_s", wall_s},
              {"steps", chain.steps},
              {"steps_per_s", static_cast<double>(chain.steps) / wall_s},
              {"ticks", ticks_},
              {"late_ticks", pacer_.late()},
              {"behind_s", static_cast<double>(pacer_.behind_ns()) * 1e-9},
              {"unsettled", unsettled_},
              {"unsettled_by", unsettled_by_},
              {"contact_s", scenario_.contact_s()},
              {"peak_A", scenario_.peak_A()},
              {"telemetry", chain.telemetry},
              {"commands", chain.commands},
              {"lost_to_host", chain.lost_to_host},
              {"lost_to_core", chain.lost_to_core},
              {"rejected", telemetry.rejected},
              {"state", static_cast<int>(telemetry.state)},
              {"faults", telemetry.faults}};
    json["usb"] = {
        {"frames_in", usb.frames_in}, {"frames_out", usb.frames_out}, {"vendor_requests", usb.vendor_requests},
        {"stalls", usb.stalls},       {"plugged", usb.plugged},       {"aborted", usb.aborted}};
    json["to_host"] = ToJson(rig_.usb.to_host_counts());
    json["to_base"] = ToJson(rig_.usb.to_base_counts());
    json["reactions"] = Json::array();
    for (const Reaction& reaction : scenario_.reactions()) json["reactions"].push_back(ToJson(reaction));
    return json;
  }

 private:
  bool OutOfTime() const {
    return options_.seconds > 0 && static_cast<double>(rig_.plant.now_ns()) * 1e-9 >= options_.seconds;
  }
  // A scenario may continue without its host.
  bool HostEnded() { return options_.scenario.empty() && rig_.host.Ended().has_value(); }

  // The programs receive a control step's frames at its end; their answer is available when the next one starts.
  base::Status Tick(sim::Recording* recording) {
    if (options_.paced) pacer_.Wait(base::kTickPeriod_ns);
    sim::HandAim aim;
    if (guide_ != nullptr && guide_->Poll(aim)) rig_.plant.SetAim(aim);
    bool settled = false;
    for (int i = 0; i < firmware::kStepsPerTick; ++i) {
      base::Status stepped = rig_.chain.Step();
      const std::size_t events = scenario_.reactions().size();
      if (stepped) stepped = scenario_.Step(rig_);
      if (!stepped) return stepped;
      const bool due = clock_.AdvanceTo(clock_.zero_ns() + rig_.plant.now_ns());
      const bool given = rig_.usb.Pump();
      if (!due && !given && scenario_.reactions().size() == events) continue;
      Settle();
      settled = true;
    }
    if (!settled) Settle();  // a program may be busy by itself
    if (unsettled_ > kUnsettledMax)
      return base::Error{unsettled_by_ + " never becomes idle: virtual time cannot advance"};
    ++ticks_;
    if (recording != nullptr) recording->Add(rig_.plant.Truth(rig_.chain.host_view(), clock_.zero_ns()));
    return base::Ok{};
  }

  void Settle() {
    if (quiet_.Wait(clock_.Processes(), kPatience_us)) return;
    ++unsettled_;
    unsettled_by_ = quiet_.busy();
  }

  // Programs also need time to exit.
  base::Status End(sim::Recording* recording) {
    for (HostProcess& program : programs_) program.Ask();
    base::Status went = base::Ok{};
    const std::int64_t end_ns = base::MonotonicNow_ns() + kEndPatience_ns;
    const auto ended = [](HostProcess& program) { return program.Ended().has_value(); };
    while (went && base::MonotonicNow_ns() < end_ns && !std::all_of(programs_.begin(), programs_.end(), ended)) {
      went = Tick(recording);
    }
    return went;
  }

  const HilOptions& options_;
  std::vector<HostProcess>& programs_;
  VirtualClock& clock_;
  std::unique_ptr<sim::HandGuide> guide_;
  Rig rig_;
  ScenarioRun scenario_;
  std::int64_t started_ns_ = base::MonotonicNow_ns();
  Pacer pacer_;
  IdleWatch quiet_;
  std::uint64_t ticks_ = 0;
  std::uint64_t unsettled_ = 0;
  std::string unsettled_by_;
};

bool WriteSummary(const std::string& path, const Json& summary) {
  const std::string text = summary.dump(2) + "\n";
  if (path.empty()) return std::fputs(text.c_str(), stdout) >= 0;
  std::ofstream file(path);
  file << text;
  return static_cast<bool>(file.flush());
}

base::Result<std::vector<HostProcess>> StartPrograms(const HilOptions& options, const VirtualClock& clock) {
  std::vector<HostProcess> programs;
  for (const std::vector<std::string>& program : options.programs) {
    auto started = HostProcess::Start(program, clock.Environment());
    if (!started) return base::Error{started.error()};
    programs.push_back(std::move(*started));
    if (clock.WaitForProcess(programs.back().pid(), kStartPatience_ms)) continue;
    return base::Error{program.front() + " does not exist, ended at once, or is statically linked"};
  }
  return programs;
}

}  // namespace

int RunHil(const base::DeviceGeometry& device, const HilOptions& options) {
  std::signal(SIGTERM, RequestStop);
  std::signal(SIGINT, RequestStop);
  std::signal(SIGPIPE, SIG_IGN);
  prctl(PR_SET_TIMERSLACK, kTimerSlack_ns);
  const base::Status possible = IdleWatch::Possible();
  if (!possible) return Fail(possible.error());

  auto board = [&] {
    const Without preload("LD_PRELOAD");
    return MakeBoard(options.board);
  }();
  if (!board) return Fail(board.error());
  sim::Plant plant(device, options.plant);
  Chain chain(plant, **board);
  auto usb = UsbEmulator::Create(chain, firmware::Settings{}.serial);
  if (!usb) return Fail(usb.error());
  std::unique_ptr<sim::HandGuide> guide;
  if (!options.hand_path.empty()) {
    auto listener = ipc::HandListener::Open(options.hand_path);
    if (!listener) return Fail(listener.error());
    guide = std::make_unique<twin::SocketGuide>(std::move(*listener));
  }
  std::unique_ptr<sim::Recording> recording;
  if (!options.record_path.empty()) {
    auto opened = sim::Recording::Open(options.record_path);
    if (!opened) return Fail(opened.error());
    recording = std::move(*opened);
  }
  const base::Status plugged = (*usb)->Plug();
  if (!plugged) return Fail(plugged.error());
  auto clock = VirtualClock::Create(options.clock_path);
  if (!clock) return Fail(clock.error());
  auto programs = StartPrograms(options, *clock);
  if (!programs) return Fail(programs.error());
  Run run(options, *programs, plant, chain, **usb, *clock, std::move(guide));
  const base::Status went = run.Go(recording.get());
  const int host_status = programs->front().Kill();
  programs->clear();
  recording.reset();
  const std::string problem = went ? "" : went.error();
  if (!WriteSummary(options.summary_path, run.Summary(host_status, problem))) {
    return Fail(options.summary_path + ": cannot be written");
  }
  return problem.empty() ? 0 : Fail(problem);
}

}  // namespace omni::hil
