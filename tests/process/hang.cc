// Applications that hang or are killed while omnid's control thread is late: what the coils do, read from the twin's
// own recording. ProcessSafetyLong has the same runs 200 times (docs/CONTRIBUTING.md); ctest leaves it out.
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/wait.h>

#include <atomic>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <random>
#include <thread>
#include <vector>

#include "service/loop/realtime.h"
#include "service/tools/common/row_table.h"
#include "tests/support/process/force_process.h"

namespace omni::test {
namespace test_process_hang {

constexpr int kRunsOfOneService = 20;  // its recording is read as a whole
constexpr int kBusyThreads = 8;
constexpr int kStopped_ms = 200;

// The only thread of omnid that waits for an epoll; 0: not found.
pid_t ControlThreadOf(pid_t process) {
  const std::string waits = std::to_string(SYS_epoll_wait) + " ";
  for (int attempt = 0; attempt < 1000; ++attempt) {
    for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(process) + "/task")) {
      std::string call;
      std::getline(std::ifstream(task.path() / "syscall"), call);
      if (call.rfind(waits, 0) == 0) return std::stoi(task.path().filename().string());
    }
    SleepMs(1);
  }
  return 0;
}

// One thread of another process, standing still during the lifetime of this.
class StoppedThread {
 public:
  explicit StoppedThread(pid_t thread) : thread_(thread) {
    stopped_ = ptrace(PTRACE_SEIZE, thread, nullptr, nullptr) == 0 &&
               ptrace(PTRACE_INTERRUPT, thread, nullptr, nullptr) == 0 && waitpid(thread, nullptr, __WALL) == thread;
  }
  ~StoppedThread() { ptrace(PTRACE_DETACH, thread_, nullptr, nullptr); }
  StoppedThread(const StoppedThread&) = delete;
  StoppedThread& operator=(const StoppedThread&) = delete;
  bool stopped() const { return stopped_; }

 private:
  const pid_t thread_;
  bool stopped_ = false;
};

class BusyThreads {
 public:
  BusyThreads() {
    for (int i = 0; i < kBusyThreads; ++i) {
      threads_.emplace_back([this] {
        while (!end_.load(std::memory_order_relaxed)) {
        }
      });
    }
  }
  ~BusyThreads() {
    end_ = true;
    for (std::thread& thread : threads_) thread.join();
  }
  BusyThreads(const BusyThreads&) = delete;
  BusyThreads& operator=(const BusyThreads&) = delete;

 private:
  std::atomic<bool> end_{false};
  std::vector<std::thread> threads_;
};

// One moment of a run, and until when its recording counts.
struct Moment {
  std::int64_t t_ns = 0, end_ns = 0;
};

// Last time after t_ns, in ms, at which a coil carries more than `share` of its current in the 20 ms before; < 0: there
// was none.
double MillisecondsAbove(const tools::CsvTable& truth, const Moment& moment, double share) {
  const std::vector<double>& t_ns = truth["t_ns"];
  const auto row = [&](std::int64_t at_ns) {
    return static_cast<std::size_t>(std::lower_bound(t_ns.begin(), t_ns.end(), static_cast<double>(at_ns)) -
                                    t_ns.begin());
  };
  const std::size_t before = row(moment.t_ns - 20'000'000), at = row(moment.t_ns), end = row(moment.end_ns);
  std::vector<double> pushing_A;
  for (std::size_t i = before; i < at; ++i) pushing_A.push_back(Current_A(truth, i));
  const double limit_A = share * tools::Mean(pushing_A);
  if (pushing_A.empty() || at == end || !(limit_A > 0.02)) return -1;
  double last_ms = 0;
  for (std::size_t i = at; i < end; ++i) {
    if (Current_A(truth, i) > limit_A) last_ms = (t_ns[i] - static_cast<double>(moment.t_ns)) * 1e-6;
  }
  return last_ms;
}

// `runs` runs of `run` with services of these options: MillisecondsAbove `share` of each. Repeats those in which the
// application had no force any more, for it was too late itself; fewer, and a failure, if there are too many.
template <class Run>
std::vector<double> Measure_ms(int runs, const std::vector<std::string>& options, double share, Run&& run) {
  std::vector<double> all_ms;
  int left = 2 * runs;
  while (static_cast<int>(all_ms.size()) < runs && left > 0) {
    ForceProcess service(options);
    std::vector<Moment> moments;
    for (int i = 0; i < kRunsOfOneService && left > 0 && static_cast<int>(all_ms.size() + moments.size()) < runs; ++i) {
      --left;
      ForkedPusher app(service, false);
      if (app.reported() != 1) continue;
      SleepMs(60);
      moments.push_back(run(service, app));
    }
    EXPECT_EQ(service.Stop(), 0);
    const auto truth = service.Truth();
    if (!truth) break;
    for (const Moment& moment : moments) {
      const double ms = MillisecondsAbove(*truth, moment, share);
      if (ms >= 0) all_ms.push_back(ms);
    }
  }
  EXPECT_EQ(all_ms.size(), runs) << "the application had no force in the others";
  return all_ms;
}

void Print(const char* what, const std::vector<double>& ms) {
  std::printf("[ figure   ] %s, %zu runs: median %.0f ms, p99 %.0f ms, longest %.0f ms\n", what, ms.size(),
              tools::Quantile(ms, 0.5), tools::Quantile(ms, 0.99), tools::Quantile(ms, 1));
}

// The application hangs up to 20 ms before or 40 ms after the control thread stands still, which it does for 200 ms.
void ExpectForceStaysAway(int runs) {
  std::mt19937 random(1);
  bool can_stop = true;
  const std::vector<double> ms =
      Measure_ms(runs, {"--log-level", "warn"}, 0.1, [&](const ServiceProcess& service, const ForkedPusher& app) {
        const pid_t control = ControlThreadOf(service.pid());
        const int lead_ms = std::uniform_int_distribution<int>(-40, 20)(random);
        Moment moment;
        const auto hang = [&] {
          moment.t_ns = base::MonotonicNow_ns();
          app.Stop();
        };
        if (lead_ms > 0) {
          hang();
          SleepMs(lead_ms);
        }
        {
          const StoppedThread stopped(control);
          can_stop = can_stop && stopped.stopped();
          if (lead_ms <= 0) {
            SleepMs(-lead_ms);
            hang();
          }
          SleepMs(kStopped_ms);
        }
        SleepMs(400);
        moment.end_ns = base::MonotonicNow_ns();
        return moment;
      });
  if (!can_stop) GTEST_SKIP() << "ptrace is not permitted here";
  Print("last force of a hung application after its stop", ms);
  EXPECT_EQ(std::count_if(ms.begin(), ms.end(), [](double each_ms) { return each_ms > 75; }), 0);
}

// Until half of the force has gone, beside busy threads.
std::vector<double> KilledApplicationsHalfForce_ms(int runs, const std::vector<std::string>& options,
                                                   const char* what) {
  const std::vector<double> ms = Measure_ms(runs, options, 0.5, [](const ServiceProcess&, ForkedPusher& app) {
    const BusyThreads busy;
    SleepMs(100);
    Moment moment{.t_ns = base::MonotonicNow_ns()};
    app.Kill();
    SleepMs(200);
    moment.end_ns = base::MonotonicNow_ns();
    return moment;
  });
  Print(what, ms);
  return ms;
}

bool HasRealtime() {
  int refused = 0;
  std::thread([&refused] { refused = loop::RequestFifo(80); }).join();
  return refused == 0;
}

TEST(ProcessSafety, ForceOfHungApplicationStaysAwayAfterControlThreadStopped) { ExpectForceStaysAway(8); }

TEST(ProcessSafety, KilledApplicationLosesHalfItsForceBesideBusyThreads) {
  const std::vector<double> ms =
      KilledApplicationsHalfForce_ms(8, {"--log-level", "warn"}, "half force gone after kill -9");
  EXPECT_LE(tools::Quantile(ms, 1), HasRealtime() ? 50 : 200);
}

TEST(ProcessSafetyLong, ForceOfHungApplicationStaysAwayAfterControlThreadStopped) { ExpectForceStaysAway(200); }

TEST(ProcessSafetyLong, KilledApplicationLosesHalfItsForceBesideBusyThreads) {
  if (!HasRealtime()) GTEST_SKIP() << "real-time priority is not granted here";
  const std::vector<double> ms =
      KilledApplicationsHalfForce_ms(200, {"--log-level", "warn"}, "half force gone after kill -9");
  EXPECT_LE(tools::Quantile(ms, 0.99), 20);
  KilledApplicationsHalfForce_ms(200, {"--log-level", "warn", "--no-realtime"},
                                 "half force gone after kill -9, without real-time priority");
}

}  // namespace test_process_hang
}  // namespace omni::test
