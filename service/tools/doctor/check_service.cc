// Does omnid run, and can programs reach it?
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "service/config/files/stop_file.h"
#include "service/protocol/socket_path.h"
#include "service/protocol/text.h"
#include "service/tools/common/output.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

// Is the control socket's folder private to this user, and its path short enough?
Finding CheckSocketFolder(const Surroundings& surroundings) {
  const std::string& path = surroundings.socket_path;
  if (const std::string problem = protocol::PathProblem(path); !problem.empty()) {
    return {Verdict::kFail, problem, "set OMNI_SOCKET for omnid and for the applications alike"};
  }
  const std::string folder = protocol::FolderOf(path);
  const protocol::FolderCheck check = protocol::CheckFolder(folder);
  switch (check.state) {
    case protocol::FolderState::kGood:
      return {Verdict::kOk, folder + " is yours alone", {}};
    case protocol::FolderState::kMissing:
      return {Verdict::kOk, folder + " does not exist yet; omnid creates it", {}};
    case protocol::FolderState::kRefused:
      break;
  }
  return {Verdict::kFail, check.problem, "make the folder your own with mode 0700: omnid and the layer use no other"};
}

// Does omnid run, and is its version the same as ours?
Finding LookForService(const Surroundings& surroundings) {
  const ServiceAnswer& service = surroundings.service;
  if (service.on_demand) return {Verdict::kOk, "omnid does not run; systemd starts it with the first application", {}};
  if (!service.running) {
    return {Verdict::kFail, service.error, "run `omnid --device twin`, or `systemctl --user enable --now omnid.socket`",
            "systemctl --user enable --now omnid.socket"};
  }
  const std::string version = TextAt(service.status, "/service/version");
  if (version != OMNI_VERSION) {
    return {Verdict::kWarn, "omnid is version " + version + ", this is omni " OMNI_VERSION,
            "install the same version of both and restart omnid"};
  }
  const nlohmann::json& problems = ArrayAt(service.status, "/problems");
  if (!problems.empty() && problems.back().is_string()) {
    return {Verdict::kWarn, "omnid reports: " + problems.back().get<std::string>(), "see `omni status`"};
  }
  return {Verdict::kOk, "omnid " + version + " runs, pid " + TextAt(service.status, "/service/pid"), {}};
}

// Is an emergency stop on? Then nothing is felt, whatever else is right.

namespace {

constexpr const char* kRelease = "when it is safe: `omni stop --release`";

std::string Pressed(const std::string& by, const std::string& at) {
  return "pressed at " + at + (by.empty() || by == "-" ? "" : " by " + by);
}

}  // namespace

Finding CheckStop(const Surroundings& surroundings) {
  const nlohmann::json& status = surroundings.service.status;
  if (!surroundings.service.running) {
    const std::optional<config::StopRecord> stop = config::FindStop(surroundings.stop_file);
    if (!stop) return {Verdict::kOk, "not pressed", {}};
    return {Verdict::kWarn,
            protocol::Printable(Pressed(stop->by, stop->at)) + ": omnid will start without force (" +
                surroundings.stop_file + ")",
            std::string(kRelease) + " while omnid runs"};
  }
  const std::string problem = TextAt(status, "/stop/problem");
  const bool failed = !problem.empty() && problem != "-";
  if (TrueAt(status, "/stop/on")) {
    return {Verdict::kWarn,
            Pressed(TextAt(status, "/stop/by"), TextAt(status, "/stop/at")) + ": no force" +
                (failed ? "; it is forgotten when omnid ends: " + problem : ""),
            kRelease};
  }
  if (failed) return {Verdict::kWarn, "released, but the next omnid starts stopped: " + problem, "remove that file"};
  return {Verdict::kOk, "not pressed", {}};
}

// May this user's processes run at real-time priority with locked memory? Late ticks can be felt.

namespace {

constexpr int kPriority = 80;  // what omnid requests
constexpr const char* kRealtimeFix =
    "copy manifests/limits/99-omni-realtime.conf to /etc/security/limits.d and log in again, or run omnid from its "
    "systemd unit, or use rtkit (steps for each: docs/howto/realtime.md)";

// In a thread of its own, so that this process keeps its scheduling. 0: granted, else errno.
int TryFifo() {
  int refused = 0;
  std::thread([&refused] {
    sched_param parameters{};
    parameters.sched_priority = kPriority;
    refused = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
  }).join();
  return refused;
}

// As omnid decides: with a finite limit MCL_FUTURE would make later allocations fail.
bool MayLockMemory() {
  rlimit limit{};
  return ::geteuid() == 0 || (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY);
}

}  // namespace

Finding CheckRealtime(const Surroundings& surroundings) {
  const nlohmann::json& status = surroundings.service.status;
  if (surroundings.service.running && status.contains("tick")) {
    if (TrueAt(status, "/tick/realtime")) {
      return {Verdict::kOk,
              "granted to omnid; " + TextAt(status, "/tick/late") + " late ticks of " + TextAt(status, "/tick/count"),
              {}};
    }
    return {Verdict::kWarn, "omnid runs without real-time priority: " + TextAt(status, "/tick/realtime_reason"),
            kRealtimeFix};
  }
  if (const int refused = TryFifo(); refused != 0) {
    return {Verdict::kWarn,
            std::string("SCHED_FIFO is refused (") + std::strerror(refused) + "): ticks will be late under load",
            kRealtimeFix};
  }
  if (!MayLockMemory()) {
    return {Verdict::kWarn, "memory may not be locked (RLIMIT_MEMLOCK): a page fault can delay a tick", kRealtimeFix};
  }
  return {Verdict::kOk, "SCHED_FIFO and locked memory are allowed", {}};
}

}  // namespace omni::tools
