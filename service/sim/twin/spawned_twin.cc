// Starts the twin as a child process and owns it. The child outlives us on purpose: when we are killed it sees the
// socket close, lets its coils go to zero and records that.
#include <fcntl.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <ctime>
#include <utility>

#include "service/base/unique_fd.h"
#include "service/device/socket_transport.h"
#include "service/sim/twin/twin.h"

extern char** environ;

namespace omni::sim {
namespace {

constexpr std::int64_t kHelloTimeout_ns = 5'000'000'000;
constexpr int kReapPatience_ms = 30'000;  // longer than any sensible linger; then SIGKILL

class Child {
 public:
  explicit Child(pid_t pid) noexcept : pid_(pid) {}
  Child(Child&& other) noexcept : pid_(std::exchange(other.pid_, -1)) {}
  Child& operator=(Child&&) = delete;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  // Precondition: our end of the socket is closed, so that the child ends by itself.
  ~Child() {
    if (pid_ < 0) return;
    for (int waited_ms = 0; waited_ms < kReapPatience_ms; ++waited_ms) {
      const pid_t ended = waitpid(pid_, nullptr, WNOHANG);
      if (ended == pid_ || (ended < 0 && errno != EINTR)) return;
      const timespec nap{0, 1'000'000};
      nanosleep(&nap, nullptr);
    }
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }

 private:
  pid_t pid_;
};

class SpawnedTwin final : public device::Transport {
 public:
  SpawnedTwin(std::unique_ptr<device::Transport> link, Child child)
      : child_(std::move(child)), link_(std::move(link)) {}

  device::ReadStatus Read(base::HallScan& scan, std::int64_t timeout_ns) noexcept override {
    return link_->Read(scan, timeout_ns);
  }
  bool Write(const base::CoilCurrents& currents) noexcept override { return link_->Write(currents); }
  const device::TransportInfo& info() const noexcept override { return link_->info(); }
  device::TransportCounters counters() const noexcept override { return link_->counters(); }
  bool PopNote(device::BaseNote& note) noexcept override { return link_->PopNote(note); }

 private:
  Child child_;  // declared first: destroyed last, after the socket is closed
  std::unique_ptr<device::Transport> link_;
};

// posix_spawn with its settings. The child gets default signals and a process group of its own: a Ctrl-C for us is not
// one for the device.
int Spawn(const std::string& program, std::vector<std::string> words, int fd, pid_t& pid) {
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, fd, fd);  // the same number: clears close-on-exec in the child only
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  sigset_t none;
  sigset_t all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int error = posix_spawn(&pid, program.c_str(), &actions, &attributes, argv.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

base::Result<std::unique_ptr<device::Transport>> SpawnTwin(const std::string& program,
                                                           const std::vector<std::string>& args) {
  int ends[2] = {-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends) != 0) {
    return base::Error{std::string("twin: cannot create a socket pair: ") + std::strerror(errno) +
                       ": raise the limit of open files"};
  }
  base::UniqueFd ours(ends[0]);
  base::UniqueFd theirs(ends[1]);
  std::vector<std::string> words{program, "--fd", std::to_string(theirs.get())};
  words.insert(words.end(), args.begin(), args.end());
  pid_t pid = -1;
  const int error = Spawn(program, std::move(words), theirs.get(), pid);
  if (error != 0) {
    return base::Error{program + ": the twin cannot be started: " + std::strerror(error) +
                       ": is the omni program beside this one, and executable?"};
  }
  Child child(pid);
  theirs.Reset();
  base::Result<std::unique_ptr<device::Transport>> link =
      device::MakeSocketTransport(std::move(ours), "twin (simulation)", kHelloTimeout_ns);
  if (!link) return base::Error{link.error()};
  return std::unique_ptr<device::Transport>(std::make_unique<SpawnedTwin>(std::move(link.value()), std::move(child)));
}

}  // namespace omni::sim
