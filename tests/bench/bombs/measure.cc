#include "tests/bench/bombs/measure.h"

#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/sealed_memory.h"

namespace omni::bombs {
namespace {

void SleepMs(int ms) { std::this_thread::sleep_for(std::chrono::milliseconds(ms)); }
double SecondsSince(std::int64_t start_ns) { return 1e-9 * static_cast<double>(base::MonotonicNow_ns() - start_ns); }

// Peak memory of a process; 0: it has ended.
double PeakMemoryOf_MB(pid_t pid) {
  std::ifstream status("/proc/" + std::to_string(pid) + "/status");
  for (std::string line; std::getline(status, line);) {
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  }
  return 0;
}

std::string Over(double limit_s) { return "> " + std::to_string(static_cast<int>(limit_s)) + " s"; }

// Replaces this process; its output is discarded.
[[noreturn]] void Become(const std::vector<std::string>& words, const std::vector<std::string>& environment) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int fd : {0, 1, 2}) dup2(nowhere, fd);
  for (const std::string& variable : environment) putenv(strdup(variable.c_str()));
  std::vector<char*> argv;
  for (const std::string& word : words) argv.push_back(strdup(word.c_str()));
  argv.push_back(nullptr);
  execv(argv[0], argv.data());
  _exit(127);
}

std::string SignalName(int signal) {
  const char* name = sigabbrev_np(signal);
  return name == nullptr ? "signal " + std::to_string(signal) : std::string("SIG") + name;
}

// An application of the service that has a session, but not the focus.
class Guest {
 public:
  Guest(const Omnid& omnid, const std::string& name)
      : connection_({.application = name, .engine = "", .socket_path = omnid.socket_path()}) {}

  void Poll() {
    connection_.Poll(base::MonotonicNow_ns());
    connection_.SignalAlive();
  }
  bool Connect() {
    for (int i = 0; i < 2000 && !connection_.connected(); ++i, SleepMs(1)) Poll();
    return connection_.connected();
  }
  client::Connection& connection() { return connection_; }

 private:
  client::Connection connection_;
};

// Starts with `begin` and waits until `outcome` returns how it ended.
template <class Begin, class Outcome>
Cost Wait(Omnid& omnid, Guest& guest, double limit_s, Begin begin, Outcome outcome) {
  Cost cost;
  if (!guest.Connect()) return {.end = "no connection"};
  omnid.ForgetPeak();
  const std::int64_t start_ns = base::MonotonicNow_ns();
  begin();
  while (cost.end.empty()) {
    guest.Poll();
    cost.end = outcome();
    cost.seconds = SecondsSince(start_ns);
    cost.memory_MB = std::max(cost.memory_MB, omnid.PeakMemory_MB());
    if (!omnid.Lives()) {
      cost.end = omnid.end();
    } else if (cost.end.empty() && cost.seconds > limit_s) {
      cost.end = Over(limit_s);
      omnid.Kill();
    }
    SleepMs(1);
  }
  return cost;
}

}  // namespace

Cost RunCommand(const std::vector<std::string>& words, double limit_s) {
  const std::int64_t start_ns = base::MonotonicNow_ns();
  int ends[2];  // closed when the child has become another program: its memory counts from then on
  if (pipe2(ends, O_CLOEXEC) != 0) return {.end = "no pipe"};
  const pid_t child = fork();
  if (child == 0) Become(words, {"XDG_CACHE_HOME=/nowhere"});
  close(ends[1]);
  char nothing = 0;
  while (read(ends[0], &nothing, 1) < 0 && errno == EINTR) {
  }
  close(ends[0]);
  Cost cost;
  int status = 0;
  bool over = false;
  while (waitpid(child, &status, WNOHANG) == 0) {
    if (!over && SecondsSince(start_ns) > limit_s) over = kill(child, SIGKILL) == 0;
    cost.memory_MB = std::max(cost.memory_MB, PeakMemoryOf_MB(child));
    SleepMs(1);
  }
  cost.seconds = SecondsSince(start_ns);
  if (over) {
    cost.end = Over(limit_s);
  } else if (WIFSIGNALED(status)) {
    cost.end = SignalName(WTERMSIG(status));
  } else {
    cost.end = WEXITSTATUS(status) == 0 ? "loaded" : "refused";
  }
  return cost;
}

bool Omnid::Start() {
  std::filesystem::create_directories(folder_ + "/run");
  std::filesystem::permissions(folder_ + "/run", std::filesystem::perms::owner_all);
  end_.clear();
  pid_ = fork();
  if (pid_ == 0) {
    Become({program_, "--device", "twin", "--log-level", "error"},
           {"OMNI_SOCKET=" + socket_path(), "XDG_CONFIG_HOME=" + folder_ + "/config",
            "XDG_CACHE_HOME=" + folder_ + "/cache"});
  }
  Guest guest(*this, "first");
  for (int i = 0; i < 5 && Lives(); ++i) {
    if (guest.Connect()) return true;
  }
  return false;
}

bool Omnid::Lives() {
  int status = 0;
  if (pid_ <= 0) return false;
  if (waitpid(pid_, &status, WNOHANG) == 0) return true;
  pid_ = -1;
  end_ = WIFSIGNALED(status) ? SignalName(WTERMSIG(status)) : "exit " + std::to_string(WEXITSTATUS(status));
  return false;
}

void Omnid::Kill() {
  if (pid_ <= 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

void Omnid::ForgetPeak() const { std::ofstream("/proc/" + std::to_string(pid_) + "/clear_refs") << "5"; }

double Omnid::PeakMemory_MB() const { return PeakMemoryOf_MB(pid_); }

Artist::Artist(const std::string& socket_path, const std::string& name)
    : connection_({.application = name, .engine = "", .socket_path = socket_path}), thread_([this] { Run(); }) {}

Artist::~Artist() {
  stop_ = true;
  thread_.join();
}

void Artist::Run() {
  std::uint64_t welcomed = 0, last_count = 0;
  while (!stop_) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    connection_.Poll(now_ns);
    connection_.SignalAlive();
    if (connection_.connected() && welcomed != connection_.welcomes()) {
      welcomed = connection_.welcomes();
      connection_.SendSession(protocol::SessionState::kBegun);
      connection_.SendSession(protocol::SessionState::kFocused);
      connection_.RequestSurfaces(true);
    }
    const auto surfaces = connection_.surfaces();
    protocol::SurfacePulse pulse;
    if (surfaces != nullptr && surfaces->ReadPulse(pulse) && pulse.poll_count != last_count) {
      last_count = pulse.poll_count;
      ++frames_;
      const std::int64_t last_ns = last_ns_.exchange(now_ns);
      if (last_ns > 0) pause_ns_ = std::max(pause_ns_.load(), now_ns - last_ns);
    }
    SleepMs(1);
  }
}

double Artist::LongestPause_ms() {
  const std::int64_t since_last_ns = base::MonotonicNow_ns() - last_ns_;
  return 1e-6 * static_cast<double>(std::max(pause_ns_.exchange(0), since_last_ns));
}

Cost LoadByEntry(Omnid& omnid, const std::string& application, double limit_s) {
  Guest guest(omnid, application);
  const auto loaded = [&]() -> std::string {
    for (const protocol::Notice& notice : guest.connection().PopNotices())
      return notice.level == 2 ? "refused" : "loaded";
    // If a scene was loaded without a message, the status has its name.
    const std::string text = guest.connection().PopStatus();
    if (text.find("\"scene\":\"/") == std::string::npos) {
      guest.connection().Send(protocol::StatusRequest{});
      return {};
    }
    const nlohmann::json status = nlohmann::json::parse(text, nullptr, false);
    for (const nlohmann::json& client : status["clients"]) {
      if (client["application"] == application && client["scene"].is_string() && client["scene"] != "") return "loaded";
    }
    return {};
  };
  return Wait(
      omnid, guest, limit_s, [&] { guest.connection().SendSession(protocol::SessionState::kBegun); }, loaded);
}

Cost LoadByDocument(Omnid& omnid, const std::string& application, const std::string& document, double limit_s) {
  Guest guest(omnid, application);
  const auto memory = base::SealedCopy("bomb", document);
  if (!memory.ok()) return {.end = "no memory"};
  protocol::HapticSceneLoad load;
  load.number = 1;
  load.bytes = document.size();
  load.flags = protocol::kSceneTouchUntagged;
  const auto ended = [&]() -> std::string {
    for (const client::HapticSceneUpdate& update : guest.connection().PopHapticSceneUpdates()) {
      if (update.is_table) continue;
      if (update.state.status == protocol::HapticSceneStatus::kFailed) return "refused";
      if (update.state.status == protocol::HapticSceneStatus::kReady) return "loaded";
    }
    return {};
  };
  return Wait(
      omnid, guest, limit_s, [&] { guest.connection().Send(load, memory->get()); }, ended);
}

}  // namespace omni::bombs
