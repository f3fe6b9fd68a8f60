#include "service/daemon/log_queue.h"

#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <mutex>
#include <string_view>
#include <system_error>
#include <utility>

#include <spdlog/details/os.h>
#include <spdlog/sinks/base_sink-inl.h>  // for another mutex than the library has it for
#include <spdlog/spdlog.h>

#include "service/base/clock.h"
#include "service/base/threads/realtime_threads.h"
#include "service/base/unique_fd.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#include <sanitizer/common_interface_defs.h>
#endif

namespace omni::daemon {

// Outlives a writer that was abandoned because no process reads the log.
struct LogQueue::State {
  base::UniqueFd out;   // standard error as it was
  base::UniqueFd pipe;  // its reading end
  base::UniqueFd stop;  // readable: write what is queued and end
  std::atomic<bool> writing{false};
  std::atomic<bool> ended{false};
  std::atomic<std::uint64_t> lost{0};  // lines, since the last report
};

namespace {

constexpr int kReport_ms = 1000;         // between checks of lines that are held back
constexpr std::size_t kLineMax = 4096;   // a longer one is cut
constexpr std::size_t kReadMax = 65536;  // bytes of a pipe [pipe(7)]
static_assert(kLineMax <= PIPE_BUF, "a line goes into the pipe whole or not at all");

std::atomic<LogQueue::State*> current{nullptr};  // for signal handlers

[[noreturn]] void ThrowErrno(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

void Nap() noexcept {
  const timespec millisecond{0, 1'000'000};
  nanosleep(&millisecond, nullptr);
}

// Into the pipe, in one piece.
class PipeSink final : public spdlog::sinks::base_sink<base::PriorityMutex> {
 public:
  PipeSink(std::shared_ptr<LogQueue::State> state, bool in_colour) : state_(std::move(state)), in_colour_(in_colour) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    std::string line(text.data(), text.size());
    if (in_colour_ && message.color_range_end > message.color_range_start) {
      line.insert(message.color_range_end, "\033[m");
      line.insert(message.color_range_start, kColours.at(static_cast<std::size_t>(message.level)));
    }
    if (line.size() > kLineMax) line.replace(kLineMax - 1, std::string::npos, "\n");
    if (write(STDERR_FILENO, line.data(), line.size()) < 0) state_->lost.fetch_add(1, std::memory_order_relaxed);
  }
  void flush_() override {}

  static constexpr std::array<const char*, spdlog::level::n_levels> kColours = {
      "\033[37m", "\033[36m", "\033[32m", "\033[33m\033[1m", "\033[31m\033[1m", "\033[1m\033[41m", ""};

  const std::shared_ptr<LogQueue::State> state_;
  const bool in_colour_;
};

class Writer {
 public:
  explicit Writer(LogQueue::State& state) : state_(state) {}

  void Run() {
    for (;;) {
      const bool stop = Wait();
      state_.writing.store(true);
      const bool any = ReadSome();
      limit_.AppendDueLines(base::MonotonicNow_ns(), text_);
      if (stop && !any) PopRest();
      WriteAll();
      state_.writing.store(false);
      if (stop && !any) break;
    }
    state_.ended.store(true);
  }

 private:
  // True: the log is to end.
  bool Wait() {
    std::array<pollfd, 2> waits = {{{state_.pipe.get(), POLLIN, 0}, {state_.stop.get(), POLLIN, 0}}};
    poll(waits.data(), waits.size(), limit_.holds_back() ? kReport_ms : -1);
    return waits[1].revents != 0;
  }

  // False: there is nothing.
  bool ReadSome() {
    const ssize_t size = read(state_.pipe.get(), bytes_.data(), bytes_.size());
    if (size <= 0) return false;
    const std::int64_t now_ns = base::MonotonicNow_ns();
    line_.append(bytes_.data(), static_cast<std::size_t>(size));
    std::size_t begin = 0;
    for (std::size_t end = 0; (end = line_.find('\n', begin)) != std::string::npos; begin = end + 1) {
      limit_.Add(std::string_view(line_).substr(begin, end - begin), now_ns, text_);
    }
    line_.erase(0, begin);
    if (line_.size() >= kLineMax) limit_.Add(std::exchange(line_, {}), now_ns, text_);
    return true;
  }

  void PopRest() {
    if (!line_.empty()) limit_.Add(std::exchange(line_, {}), base::MonotonicNow_ns(), text_);
    limit_.ReportAll(base::MonotonicNow_ns(), text_);
  }

  void WriteAll() {
    if (text_.empty()) return;
    const auto lines = static_cast<std::uint64_t>(std::count(text_.begin(), text_.end(), '\n'));
    if (!WriteOut(text_)) state_.lost.fetch_add(lines);
    text_.clear();
    if (const std::uint64_t lost = state_.lost.exchange(0); lost > 0) {
      const bool said = WriteOut("omnid: " + std::to_string(lost) +
                                 " lines of this log are missing: they came faster than they were read\n");
      if (!said) state_.lost.fetch_add(lost);
    }
  }

  bool WriteOut(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t size = write(state_.out.get(), text.data(), text.size());
      if (size >= 0) {
        text.remove_prefix(static_cast<std::size_t>(size));
      } else if (errno == EAGAIN) {  // another process that shares it made it non-blocking
        pollfd wait{state_.out.get(), POLLOUT, 0};
        poll(&wait, 1, -1);
      } else if (errno != EINTR) {
        return false;
      }
    }
    return true;
  }

  LogQueue::State& state_;
  LineLimit limit_;
  std::array<char, kReadMax> bytes_{};
  std::string line_;  // that has no end yet
  std::string text_;  // to be written
};

// What the C and C++ libraries and sanitizers write before they end the process would stay in the pipe.
void FlushBeforeAbort(int signal) {
  LogQueue::Flush(LogQueue::kEndWait_ms);
  std::signal(signal, SIG_DFL);
  raise(signal);
}

void FlushBeforeDeath() { LogQueue::Flush(LogQueue::kEndWait_ms); }

}  // namespace

LogQueue::LogQueue(const std::string& level) : state_(std::make_shared<State>()) {
  // [no-color.org]
  const char* const no_colour = secure_getenv("NO_COLOR");
  const bool in_colour = isatty(STDERR_FILENO) == 1 && spdlog::details::os::is_color_terminal() &&
                         (no_colour == nullptr || *no_colour == 0);
  state_->out.Reset(fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1));
  if (!state_->out) state_->out.Reset(open("/dev/null", O_WRONLY | O_CLOEXEC));  // started without one
  output_before_ = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  int ends[2];
  if (pipe2(ends, O_CLOEXEC | O_NONBLOCK) != 0) ThrowErrno("a pipe for the log");
  state_->pipe.Reset(ends[0]);
  const base::UniqueFd entry(ends[1]);
  state_->stop.Reset(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
  if (!state_->stop || dup2(entry.get(), STDOUT_FILENO) < 0 || dup2(entry.get(), STDERR_FILENO) < 0) {
    ThrowErrno("descriptors for the log");
  }
  auto logger = std::make_shared<spdlog::logger>("omnid", std::make_shared<PipeSink>(state_, in_colour));
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(std::move(logger));
  current.store(state_.get());
  std::signal(SIGABRT, FlushBeforeAbort);
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  __sanitizer_set_death_callback(FlushBeforeDeath);
#else
  static_cast<void>(FlushBeforeDeath);
#endif
  // Other threads handle signals: a new thread inherits the mask of its creator.
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  thread_ = std::thread([state = state_] { Writer(*state).Run(); });
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

LogQueue::~LogQueue() {
  const std::uint64_t one = 1;
  const bool asked = write(state_->stop.get(), &one, sizeof one) == sizeof one;
  for (int ms = 0; asked && ms < kEndWait_ms && !state_->ended.load(); ++ms) Nap();
  std::signal(SIGABRT, SIG_DFL);
  current.store(nullptr);
  dup2(state_->out.get(), STDERR_FILENO);
  dup2(output_before_ >= 0 ? output_before_ : state_->out.get(), STDOUT_FILENO);
  close(output_before_);
  if (state_->ended.load()) {
    thread_.join();
  } else {
    thread_.detach();
  }
}

void LogQueue::Flush(int most_ms) noexcept {
  State* const state = current.load();
  if (state == nullptr) return;
  for (int ms = 0; ms < most_ms; ++ms) {
    int queued = 0;
    ioctl(state->pipe.get(), FIONREAD, &queued);
    if (queued == 0 && !state->writing.load()) return;
    Nap();
  }
}

}  // namespace omni::daemon
