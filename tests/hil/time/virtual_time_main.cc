// omni_virtual_time PROGRAM ARGUMENTS...: the program, and all that it starts, in virtual time. Whenever all
// threads sleep (tests/hil/time/idle_watch.h), time advances to the first timer: computation takes no time, however
// busy the machine is, and a wait during which nothing happens ends at once. Exit status: the program's.
#include <sys/prctl.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include "tests/hil/time/host_process.h"
#include "tests/hil/time/idle_watch.h"
#include "tests/hil/time/virtual_clock.h"

namespace {

using omni::hil::HostProcess;
using omni::hil::IdleWatch;
using omni::hil::VirtualClock;

constexpr unsigned long kTimerSlack_ns = 1000;  // the naps between two checks are short
constexpr std::int64_t kPatience_us = 1'000'000;
constexpr auto kNap = std::chrono::milliseconds(1);  // of real time, while there is no timer to wait for
constexpr int kCannotRun = 127;                      // as shells say it

constexpr const char* kOwnChildren = "/proc/thread-self/children";

// Also those that are not under the clock yet, or never will be, and those whose parent has ended. Each thread has
// children of its own [proc(5)].
void AddDescendants(pid_t pid, std::vector<pid_t>& all) {
  std::error_code gone;
  std::filesystem::directory_iterator thread("/proc/" + std::to_string(pid) + "/task", gone);
  for (; !gone && thread != std::filesystem::directory_iterator(); thread.increment(gone)) {
    std::ifstream children(thread->path() / "children");
    for (pid_t child = 0; children >> child;) {
      all.push_back(child);
      AddDescendants(child, all);
    }
  }
}
std::vector<pid_t> Descendants() {
  std::vector<pid_t> all;
  AddDescendants(getpid(), all);
  return all;
}

int Run(const std::vector<std::string>& arguments) {
  const auto fail = [](const std::string& message) {
    std::fprintf(stderr, "omni_virtual_time: %s\n", message.c_str());
    return kCannotRun;
  };
  if (arguments.empty()) return fail("a program is missing: omni_virtual_time PROGRAM ARGUMENTS...");
  if (const omni::base::Status possible = IdleWatch::Possible(); !possible) return fail(possible.error());
  if (access(kOwnChildren, R_OK) != 0) return fail(std::string("needs ") + kOwnChildren + " (CONFIG_PROC_CHILDREN)");
  if (prctl(PR_SET_CHILD_SUBREAPER, 1) != 0) return fail("orphans cannot be adopted");
  prctl(PR_SET_TIMERSLACK, kTimerSlack_ns);
  auto clock = VirtualClock::Create("");
  if (!clock) return fail(clock.error());
  auto program = HostProcess::Start(arguments, clock->Environment());
  if (!program) return fail(program.error());
  IdleWatch quiet;
  for (;;) {
    if (const auto status = program->Ended()) return *status;
    const std::vector<pid_t> processes = Descendants();
    if (!quiet.Wait(processes, kPatience_us) || Descendants() != processes) continue;
    clock->Processes();
    if (!clock->AdvanceToNext()) std::this_thread::sleep_for(kNap);
  }
}

}  // namespace

int main(int argc, char** argv) { return Run({argv + 1, argv + argc}); }
