#include "tests/hil/hil_run.h"

#include <sched.h>
#include <stdlib.h>
#include <sys/prctl.h>

#include <csignal>
#include <cstdio>
#include <fstream>
#include <memory>
#include <optional>
#include <utility>

#include <nlohmann/json.hpp>

#include "firmware/core/settings.h"
#include "service/sim/recording.h"
#include "tests/hil/chain.h"
#include "tests/hil/hil_board.h"
#include "tests/hil/host_process.h"
#include "tests/hil/pacer.h"
#include "tests/hil/scenario.h"
#include "tests/hil/usb_emulator.h"

namespace omni::hil {
namespace {

using Json = nlohmann::ordered_json;

constexpr unsigned long kTimerSlack_ns = 1000;  // umockdev sleeps in every emulated call; 50 us of slack would be felt
constexpr int kRealTimePriority = 30;
constexpr std::int64_t kHostPatience_us = 20'000;  // virtual time goes on without a host that says nothing

volatile std::sig_atomic_t stop_requested = 0;
void RequestStop(int) { stop_requested = 1; }

int Fail(const std::string& message) {
  std::fprintf(stderr, "omni_hil: %s\n", message.c_str());
  return 1;
}

// Takes a variable out of the environment for as long as it lives: an emulator started meanwhile is not preloaded.
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
  Run(const HilOptions& options, HostProcess& host, sim::Plant& plant, Chain& chain, UsbEmulator& usb)
      : options_(options),
        rig_{plant, usb, host, chain},
        scenario_(FindScenario(options.scenario), options.contact_timeout_s) {}

  base::Status Go(sim::Recording* recording) {
    while (stop_requested == 0 && !scenario_.ended() && !OutOfTime() && !HostEnded()) {
      WaitForTick();
      for (int i = 0; i < firmware::kStepsPerTick; ++i) {
        base::Status stepped = rig_.chain.Step();
        if (stepped) stepped = scenario_.Step(rig_);
        if (!stepped) return stepped;
        rig_.usb.Pump();
      }
      if (recording != nullptr) recording->Add(rig_.plant.Truth(rig_.chain.host_view(), pacer_.zero_ns()));
    }
    return base::Ok{};
  }

  Json Summary(int host_status, const std::string& problem) const {
    const double device_s = static_cast<double>(rig_.plant.now_ns()) * 1e-9;
    const double wall_s = static_cast<double>(base::MonotonicNow_ns() - started_ns_) * 1e-9;
    const ChainCounts& chain = rig_.chain.counts();
    const UsbCounts usb = rig_.usb.counts();
    const wire::Telemetry& telemetry = rig_.chain.telemetry();
    const PaceCounts& pace = pacer_.counts();
    Json json{{"board", options_.board},
              {"paced", options_.paced},
              {"scenario", options_.scenario},
              {"problem", problem},
              {"host_status", host_status},
              {"device_s", device_s},
              {"wall_s", wall_s},
              {"steps", chain.steps},
              {"steps_per_s", static_cast<double>(chain.steps) / wall_s},
              {"ticks", pace.waits},
              {"late_ticks", pace.late},
              {"worst_late_ms", static_cast<double>(pace.worst_late_ns) * 1e-6},
              {"slips", pace.slips},
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
  // A scenario may go on without its host.
  bool HostEnded() { return options_.scenario.empty() && rig_.host.Ended().has_value(); }

  void WaitForTick() {
    if (options_.paced) {
      pacer_.WaitFor(rig_.plant.now_ns() + base::kTickPeriod_ns);
    } else {
      rig_.chain.WaitForHost(kHostPatience_us);
    }
  }

  const HilOptions& options_;
  Rig rig_;
  ScenarioRun scenario_;
  std::int64_t started_ns_ = base::MonotonicNow_ns();
  Pacer pacer_;
};

bool WriteSummary(const std::string& path, const Json& summary) {
  const std::string text = summary.dump(2) + "\n";
  if (path.empty()) return std::fputs(text.c_str(), stdout) >= 0;
  std::ofstream file(path);
  file << text;
  return static_cast<bool>(file.flush());
}

// A real base does not wait for a scheduler. Where this is refused the chain merely ticks less evenly. Before any
// thread or board is started: umockdev's thread is the bus, QEMU is the base, and both inherit it.
void AskForRealTime() {
  sched_param param{};
  param.sched_priority = kRealTimePriority;
  sched_setscheduler(0, SCHED_FIFO, &param);
}

}  // namespace

int RunHil(const base::DeviceGeometry& device, const HilOptions& options) {
  if (!options.scenario.empty() && FindScenario(options.scenario) == nullptr) {
    std::string known;
    for (const Scenario& scenario : AllScenarios()) known += std::string(" ") + scenario.name;
    return Fail("no scenario \"" + options.scenario + "\": there are" + known);
  }
  std::signal(SIGTERM, RequestStop);
  std::signal(SIGINT, RequestStop);
  std::signal(SIGPIPE, SIG_IGN);
  prctl(PR_SET_TIMERSLACK, kTimerSlack_ns);
  if (options.paced) AskForRealTime();

  auto board = [&] {
    const Without preload("LD_PRELOAD");
    return MakeBoard(options.board);
  }();
  if (!board) return Fail(board.error());
  sim::Plant plant(device, options.plant);
  Chain chain(plant, **board);
  auto usb = UsbEmulator::Create(chain, firmware::Settings{}.serial);
  if (!usb) return Fail(usb.error());
  std::unique_ptr<sim::Recording> recording;
  if (!options.record_path.empty()) {
    auto opened = sim::Recording::Open(options.record_path);
    if (!opened) return Fail(opened.error());
    recording = std::move(*opened);
  }
  const base::Status plugged = (*usb)->Plug();
  if (!plugged) return Fail(plugged.error());
  auto host = HostProcess::Start(options.program);
  if (!host) return Fail(host.error());
  Run run(options, *host, plant, chain, **usb);
  const base::Status went = run.Go(recording.get());
  const int host_status = host->Stop();
  recording.reset();
  const std::string problem = went ? "" : went.error();
  if (!WriteSummary(options.summary_path, run.Summary(host_status, problem))) {
    return Fail(options.summary_path + ": cannot be written");
  }
  return problem.empty() ? 0 : Fail(problem);
}

}  // namespace omni::hil
