// May this user's processes run at real-time priority with locked memory? Late ticks can be felt.
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cstring>
#include <thread>

#include "service/tools/common/json_text.h"
#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {
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
