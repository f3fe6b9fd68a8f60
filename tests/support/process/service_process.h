// omnid with the twin as real processes in their own folder, and applications that use its protocol.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/base/clock.h"
#include "service/client/connection.h"
#include "service/tools/common/files.h"
#include "tests/support/process/child_process.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {

inline void SleepMs(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }

// Every 4 s over the base's centre: down to 47 mm, a rest, on to 42 mm, a rest, up. A face at 50 mm is grabbed by the
// first press and pushed in by the second one; a hand that only rests on it moves nothing.
inline constexpr const char* kPressThenDeeper = R"({"name": "press then deeper", "repeat": true, "waypoints": [
  {"s": 0.5, "tip_m": [0, 0, 0.062], "axis": [0, 0, -1]}, {"s": 0.5, "tip_m": [0, 0, 0.047], "axis": [0, 0, -1]},
  {"s": 1.0, "tip_m": [0, 0, 0.047], "axis": [0, 0, -1]}, {"s": 0.5, "tip_m": [0, 0, 0.042], "axis": [0, 0, -1]},
  {"s": 1.5, "tip_m": [0, 0, 0.042], "axis": [0, 0, -1]}]})";

class ServiceProcess {
 public:
  ServiceProcess() : ServiceProcess(OMNI_SOURCE_DIR "/scenes/extrusion.glb", kPressOnTheBlock) {}
  // For applications called process_test*: this scene, and a hand by this script.
  ServiceProcess(const std::string& scene, const std::string& hand) {
    std::filesystem::create_directories(folder_.Path("run"));
    std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
    folder_.Write("config/omni/apps.d/test.toml", "application = \"process_test*\"\nscene = \"" + scene + "\"\n");
    folder_.Write("hand.json", hand);
  }
  ~ServiceProcess() {
    if (pid() > 0) {
      EXPECT_EQ(Stop(), 0);
    }
  }
  std::string Path(const std::string& below) const { return folder_.Path(below); }
  ServiceProcess(const ServiceProcess&) = delete;
  ServiceProcess& operator=(const ServiceProcess&) = delete;

  void Start() { Start({"--log-level", "warn"}, {}); }
  // With these additional arguments. Its log goes to `log_path`, a file or a pipe, if given.
  void Start(const std::vector<std::string>& more, const std::string& log_path) {
    std::vector<std::string> words{std::string(OMNI_BINARY_DIR) + "/bin/omnid",
                                   "--device",
                                   "twin",
                                   "--twin",
                                   "ideal",
                                   "--twin-script",
                                   hand_path(),
                                   "--twin-record",
                                   truth_path(),
                                   "--replace"};  // of a service that ran before
    words.insert(words.end(), more.begin(), more.end());
    StartProgram(words, log_path);
  }
  // Another device, or none.
  void StartProgram(std::vector<std::string> words, const std::string& log_path, test::Environment more = {}) {
    if (!log_path.empty()) {
      words.insert(words.begin(), {"/bin/sh", "-c", "exec \"$@\" 2>\"$0\"", log_path});
    }
    test::Environment environment{"OMNI_SOCKET=" + socket_path(), "XDG_CONFIG_HOME=" + folder_.Path("config"),
                                  "XDG_CACHE_HOME=" + folder_.Path("cache"), "XDG_STATE_HOME=" + state_folder()};
    environment.insert(environment.end(), more.begin(), more.end());
    auto started = test::ChildProcess::Start(words, environment);
    if (started.ok()) process_ = std::make_unique<test::ChildProcess>(std::move(*started));
  }

  pid_t pid() const { return process_ == nullptr ? -1 : process_->pid(); }
  void Signal(int signal) { kill(pid(), signal); }
  int Wait() { return process_->Wait(); }
  // Requests its end and returns the exit status: 0, or that of a sanitizer.
  int Stop() {
    Signal(SIGTERM);
    return Wait();
  }

  std::string socket_path() const { return folder_.Path("run/omnid.sock"); }
  std::string truth_path() const { return folder_.Path("truth.csv"); }
  std::string hand_path() const { return folder_.Path("hand.json"); }
  std::string state_folder() const { return folder_.Path("state"); }
  std::string latch_path() const { return state_folder() + "/omni/emergency_stop.toml"; }
  std::string cache_folder() const { return folder_.Path("cache/omni"); }

  // The twin's own recording, once its process has finished writing: it outlives omnid briefly.
  std::optional<tools::CsvTable> Truth() const {
    std::uintmax_t last = 0;
    int still = 0;
    for (int i = 0; i < 200 && still < 8; ++i) {
      SleepMs(100);
      std::error_code error;
      const std::uintmax_t size = std::filesystem::file_size(truth_path(), error);
      still = size == last && size > 0 ? still + 1 : 0;
      last = size;
    }
    auto table = tools::CsvTable::Read(truth_path());
    if (!table.ok()) return std::nullopt;
    return std::move(*table);
  }

 private:
  // Down onto the block's top, then pressing for a long time.
  static constexpr const char* kPressOnTheBlock = R"({"name": "press", "repeat": false, "waypoints": [
      {"s": 0, "tip_m": [0.008, 0.004, 0.085], "axis": [0, 0, -1]},
      {"s": 0.6, "tip_m": [0.008, 0.004, 0.080], "axis": [0, 0, -1]},
      {"s": 0.8, "tip_m": [0.008, 0.004, 0.039], "axis": [0, 0, -1]},
      {"s": 60, "tip_m": [0.008, 0.004, 0.039], "axis": [0, 0, -1]}]})";

  const TempFolder folder_;  // outlives the process
  std::unique_ptr<test::ChildProcess> process_;
};

// An application: connects, becomes focused, sends a heartbeat every `period_ms`.
class TestApplication {
 public:
  explicit TestApplication(const ServiceProcess& service, const std::string& name = "process_test")
      : TestApplication(service.socket_path(), name) {}
  TestApplication(const std::string& socket_path, const std::string& name)
      : connection_({.application = name, .engine = "", .socket_path = socket_path, .retry_interval_ns = 50'000'000}) {}

  // Runs for `ms` or until `until` returns true. False: it never did.
  template <class Until>
  bool Run(int ms, int period_ms, Until until) {
    const std::int64_t end_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(ms) * 1'000'000;
    while (base::MonotonicNow_ns() < end_ns) {
      connection_.Poll(base::MonotonicNow_ns());
      connection_.SignalAlive();
      if (until()) return true;
      SleepMs(period_ms);
    }
    return false;
  }
  void Run(int ms, int period_ms) {
    Run(ms, period_ms, [] { return false; });
  }

  bool Focus() {
    const bool connected = Run(5000, 5, [&] { return connection_.connected(); });
    return connected && connection_.SendSession(protocol::SessionState::kBegun) &&
           connection_.SendSession(protocol::SessionState::kFocused);
  }

  // Waits until the pen is pushed back with at least `force_N`.
  bool WaitForForce(double force_N) {
    return Run(8000, 5, [&] { return Force_N() > force_N; });
  }

  double Force_N() const {
    const auto state = connection_.state();
    protocol::ToolSample sample;
    if (state == nullptr || !state->ReadNewest(sample)) return 0;
    const auto& f = sample.force_base_N;
    return std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  }

  client::Connection& connection() { return connection_; }

 private:
  client::Connection connection_;
};

// Largest |current| of the three coils in row i of the twin's recording.
inline double Current_A(const tools::CsvTable& truth, std::size_t i) {
  return std::max(
      {std::abs(truth["current_x_A"][i]), std::abs(truth["current_y_A"][i]), std::abs(truth["current_z_A"][i])});
}

// Milliseconds from t_ns to the last moment within `horizon_ms` at which a coil had more than 20 mA; 0: at none; < 0:
// no recording of that time.
inline double MillisecondsToZero(const tools::CsvTable& truth, std::int64_t t_ns, double horizon_ms) {
  double last_ms = 0;
  bool any = false;
  for (std::size_t i = 0; i < truth.rows(); ++i) {
    const double ms = (truth["t_ns"][i] - static_cast<double>(t_ns)) * 1e-6;
    if (ms < 0 || ms > horizon_ms) continue;
    any = true;
    if (Current_A(truth, i) > 0.02) last_ms = ms;
  }
  return any ? last_ms : -1;
}

inline constexpr double kWholeRecording_ms = 1e6;

// Ends the service: milliseconds from t_ns until the coils were at zero for the rest of `horizon_ms`. < 0: no recording
// of that time.
inline double StopAndTimeToZero_ms(ServiceProcess& service, std::int64_t t_ns, double horizon_ms = kWholeRecording_ms) {
  EXPECT_EQ(service.Stop(), 0);
  const auto truth = service.Truth();
  return truth.has_value() ? MillisecondsToZero(*truth, t_ns, horizon_ms) : -1;
}

// The same, printed as a figure named `what`; the coils must have been pushing until then.
inline double StopAndPrintTimeToZero_ms(ServiceProcess& service, const char* what, std::int64_t t_ns,
                                        double horizon_ms = kWholeRecording_ms) {
  EXPECT_EQ(service.Stop(), 0);
  const auto truth = service.Truth();
  if (!truth.has_value()) return -1;
  EXPECT_GT(MillisecondsToZero(*truth, t_ns - 20'000'000, 20), 0) << what << ": no force before";
  const double ms = MillisecondsToZero(*truth, t_ns, horizon_ms);
  std::printf("[ figure   ] coils at zero %.1f ms after %s\n", ms, what);
  return ms;
}

}  // namespace omni::test
