#include "service/daemon/scenes/builder_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <utility>

#include "service/base/sanitized.h"
#include "service/protocol/packet_socket.h"

namespace omni::daemon {
namespace {

constexpr std::uint64_t kMegabyte = 1'000'000;
// Of address space, which every process uses before it does anything: program, libraries, stack, and what its heap has
// reserved and not used.
constexpr std::uint64_t kPlainSpace = 96 * kMegabyte;
constexpr rlim_t kOpenFiles = 128;  // a hundred beside the document
// A builder that has used no processor for so long has stopped working: it waits for omnid alone.
constexpr int kLook_ms = 5000, kPatience = 12;

// Kills for lack of memory, of any process; 0 where the kernel does not say.
std::uint64_t OomKills() {
  std::ifstream file("/proc/vmstat");
  std::string key;
  for (std::uint64_t value = 0; file >> key >> value;) {
    if (key == "oom_kill") return value;
  }
  return 0;
}

std::string ReasonOf(int error) { return std::strerror(error); }  // NOLINT(concurrency-mt-unsafe)

// Not by fork, which would copy the maps of a process with locked memory; nothing of this one stays open in it but the
// socket.
int Spawn(const std::string& program, int socket, pid_t& pid) {
  std::string name = program;
  const std::array<char*, 2> words = {name.data(), nullptr};
  std::array<char*, 1> environment = {nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_adddup2(&actions, socket, builder::kSocket);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDWR, 0);
  posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDERR_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, builder::kSocket + 1);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  const sched_param ordinary{};
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setschedpolicy(&attributes, SCHED_OTHER);
  posix_spawnattr_setschedparam(&attributes, &ordinary);
  posix_spawnattr_setflags(
      &attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSCHEDULER);
  const int error = posix_spawn(&pid, program.c_str(), &actions, &attributes, words.data(), environment.data());
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  return error;
}

}  // namespace

BuilderProcess::BuilderProcess(const std::string& program, const CancelEvent& cancel)
    : cancel_(cancel), oom_kills_(OomKills()) {
  std::array<int, 2> ends{-1, -1};
  if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0)
    throw BuilderEnded{"no socket for a builder: " + ReasonOf(errno)};
  socket_.Reset(ends[0]);
  const base::UniqueFd theirs(ends[1]);
  const int error = Spawn(program, theirs.get(), pid_);
  if (error != 0) {
    pid_ = -1;
    throw BuilderEnded{program + ": cannot be started: " + ReasonOf(error) + "; install omni-builder beside omnid"};
  }
  const rlimit files{kOpenFiles, kOpenFiles};
  prlimit(pid_, RLIMIT_NOFILE, &files, nullptr);
}

BuilderProcess::~BuilderProcess() { End(); }

void BuilderProcess::Limit(std::uint64_t bytes) {
  limit_bytes_ = bytes;
  if (base::kSanitized) return;
  rlimit space{};
  if (prlimit(pid_, RLIMIT_AS, nullptr, &space) == 0) {
    space.rlim_cur = std::min<rlim_t>(bytes + kPlainSpace, space.rlim_max);
    if (prlimit(pid_, RLIMIT_AS, &space, nullptr) == 0) return;
  }
  if (errno != ESRCH) throw BuilderEnded{"the builder cannot be limited: " + ReasonOf(errno)};
}

void BuilderProcess::SendBytes(const std::string& bytes, const std::vector<int>& fds) {
  for (;;) {
    const protocol::SendResult result =
        protocol::SendPacket(socket_.get(), bytes.data(), bytes.size(), fds.data(), fds.size());
    if (result == protocol::SendResult::kSent) return;
    if (result == protocol::SendResult::kGone) ThrowHowItEnded();
    Wait(POLLOUT);
  }
}

void BuilderProcess::Message::ThrowMisshapen() {
  throw BuilderEnded{"the builder has sent a message of a wrong length; its result is not used"};
}

BuilderProcess::Message BuilderProcess::Receive() {
  std::array<char, builder::kMaxMessage> buffer;
  for (;;) {
    const protocol::Received received = protocol::ReceivePacket(socket_.get(), buffer.data(), buffer.size());
    switch (received.result) {
      case protocol::ReceiveResult::kPacket: {
        Message message;
        message.bytes.assign(buffer.data(), received.size);
        if (received.size < sizeof message.kind) Message::ThrowMisshapen();
        std::memcpy(&message.kind, buffer.data(), sizeof message.kind);
        if (cancel_.is_set()) throw BuilderEnded{};
        return message;
      }
      case protocol::ReceiveResult::kEnd:
        ThrowHowItEnded();
      case protocol::ReceiveResult::kTooLong:
      case protocol::ReceiveResult::kNoRoom:
        throw BuilderEnded{"the builder has sent a message that is too long, or a descriptor; its result is not used"};
      case protocol::ReceiveResult::kNothing:
        Wait(POLLIN);
    }
  }
}

bool BuilderProcess::HasWorked() {
  clockid_t clock{};
  timespec used{};
  if (clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &used) != 0) return true;  // its end is seen
  const std::int64_t now_ns = std::int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
  return std::exchange(cpu_ns_, now_ns) != now_ns;
}

void BuilderProcess::Wait(short event) {
  for (int idle = 0; idle < kPatience;) {
    std::array<pollfd, 2> waits = {{{socket_.get(), event, 0}, {cancel_.fd(), POLLIN, 0}}};
    const int ready = poll(waits.data(), waits.size(), kLook_ms);
    if (cancel_.is_set()) throw BuilderEnded{};
    if (ready > 0) return;
    if (ready == 0) idle = HasWorked() ? 0 : idle + 1;
  }
  throw BuilderEnded{"the builder does not answer; load the scene again"};
}

// Kills it and waits for its end, which is soon.
int BuilderProcess::WaitForEnd() {
  int status = 0;
  if (pid_ < 0) return 0;
  while (waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return status;
}

void BuilderProcess::End() {
  if (pid_ < 0) return;
  kill(pid_, SIGKILL);
  WaitForEnd();
}

// The socket is closed: it has ended, or is about to.
void BuilderProcess::ThrowHowItEnded() {
  if (pid_ < 0) throw BuilderEnded{};
  std::array<pollfd, 1> moment = {{{cancel_.fd(), POLLIN, 0}}};
  for (int i = 0; i < 100; ++i) {
    siginfo_t ended{};
    if (waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == pid_) break;
    poll(moment.data(), moment.size(), 10);
    if (cancel_.is_set()) throw BuilderEnded{};
  }
  siginfo_t ended{};
  const bool by_itself =
      waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 && ended.si_pid == pid_;
  kill(pid_, SIGKILL);
  const int status = WaitForEnd();
  if (!by_itself) throw BuilderEnded{"the builder closed its connection; its result is not used"};
  if (!WIFSIGNALED(status)) {
    throw BuilderEnded{"the builder ended without a result (exit status " + std::to_string(WEXITSTATUS(status)) + ")"};
  }
  const int signal = WTERMSIG(status);
  if (signal == SIGSYS) {
    throw BuilderEnded{"the builder was ended: it made a system call that it may not make; the file may be an attack"};
  }
  if (signal == SIGKILL && OomKills() > oom_kills_) {
    throw BuilderEnded{"the builder was killed: the computer, or the service, has no memory left; close programs"};
  }
  if (signal == SIGKILL) throw BuilderEnded{"the builder was killed, by a person or a program"};
  throw BuilderEnded{std::string("the builder crashed (") + strsignal(signal) +  // NOLINT(concurrency-mt-unsafe)
                     "); please report this file"};
}

}  // namespace omni::daemon
