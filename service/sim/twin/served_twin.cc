// The twin in a process of its own: a 1 kHz absolute timer drives TwinCore, its frames travel over a seqpacket socket.
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <utility>

#include "service/base/clock.h"
#include "service/sim/twin/twin_core.h"

namespace omni::sim {
namespace {

constexpr std::int64_t kCatchUpMax_ns = 100 * base::kTickPeriod_ns;  // later than this: the device's clock is set again
constexpr int kFramesPerTickMax = 64;                                // the rest waits for the next tick
constexpr int kRealTimePriority = 30;

volatile std::sig_atomic_t stop_requested = 0;
void RequestStop(int) { stop_requested = 1; }

// These end the loop, so that the recording is complete; the former handlers come back afterwards.
class StopSignals {
 public:
  StopSignals() {
    stop_requested = 0;
    struct sigaction action {};
    action.sa_handler = RequestStop;
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &former_[i]);
  }
  ~StopSignals() {
    for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &former_[i], nullptr);
  }
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

 private:
  static constexpr std::array<int, 3> kSignals{SIGINT, SIGTERM, SIGHUP};
  std::array<struct sigaction, kSignals.size()> former_{};
};

// A real base does not wait for the host's scheduler. Where this is refused the twin merely ticks less evenly.
void RequestRealTime() {
  sched_param param{};
  param.sched_priority = kRealTimePriority;
  pthread_setschedparam(pthread_self(), SCHED_FIFO, &param);
}

void SleepUntil(std::int64_t t_ns) {
  const timespec wake{t_ns / 1'000'000'000, t_ns % 1'000'000'000};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

class Server {
 public:
  Server(const base::DeviceGeometry& device, const TwinOptions& options, int fd, std::unique_ptr<Recording> recording)
      : core_(device, PlantOptionsOf(options), base::MonotonicNow_ns()),
        guide_(options.guide),
        fd_(fd),
        recording_(std::move(recording)) {}

  void Run(double linger_s) {
    const auto linger_ns = static_cast<std::int64_t>(linger_s * 1e9);
    core_.MoveClock(base::MonotonicNow_ns() - core_.clock_offset_ns());
    RequestHello();
    while (stop_requested == 0 && (!gone_ || base::MonotonicNow_ns() - gone_ns_ < linger_ns)) {
      WaitForTick();
      ReceiveFrames();
      HandAim aim;
      if (guide_ != nullptr && guide_->Poll(aim)) core_.SetAim(aim);
      core_.Tick();
      if (recording_) recording_->Add(core_.Truth());
      SendFrames();
    }
  }

 private:
  // A tick covers the millisecond that has just passed. Short delays are caught up tick by tick; after a long one (a
  // suspended machine) device time continues from now.
  void WaitForTick() {
    const std::int64_t due_ns = core_.clock_offset_ns() + core_.now_ns() + base::kTickPeriod_ns;
    const std::int64_t late_ns = base::MonotonicNow_ns() - due_ns;
    if (late_ns < 0) {
      SleepUntil(due_ns);
    } else if (late_ns > kCatchUpMax_ns) {
      core_.MoveClock(late_ns);
    }
  }

  void ReceiveFrames() {
    std::array<std::uint8_t, wire::kFrameSizeMax + 1> buffer;
    for (int i = 0; i < kFramesPerTickMax && !gone_; ++i) {
      const ssize_t size = recv(fd_, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_TRUNC);
      if (size > 0) {
        core_.Receive(buffer.data(), static_cast<std::size_t>(size));
      } else if (size < 0 && errno == EINTR) {
        continue;
      } else {
        if (size == 0 || (errno != EAGAIN && errno != EWOULDBLOCK)) PeerGone();
        return;
      }
    }
  }

  // The host need not request the first HELLO.
  void RequestHello() {
    std::array<std::uint8_t, wire::kHeaderSize + wire::kTrailerSize> frame;
    wire::Header header;
    header.type = wire::MessageType::kHello;
    core_.Receive(frame.data(), wire::SealFrame(header, 0, frame.data(), frame.size()).size);
    SendFrames();
  }

  void SendFrames() {
    std::array<std::uint8_t, wire::kFrameSizeMax> frame;
    for (std::size_t size = 0; (size = core_.NextFrame(frame.data(), frame.size())) != 0;) Send(frame.data(), size);
  }

  // Never waits: a host that does not read loses frames and sees the gap in the sequence.
  void Send(const std::uint8_t* frame, std::size_t size) {
    if (gone_ || send(fd_, frame, size, MSG_DONTWAIT | MSG_NOSIGNAL) >= 0) return;
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != ENOBUFS && errno != EINTR) PeerGone();
  }

  void PeerGone() {
    gone_ = true;
    gone_ns_ = base::MonotonicNow_ns();
  }

  TwinCore core_;
  std::shared_ptr<HandGuide> guide_;
  int fd_;
  std::unique_ptr<Recording> recording_;
  bool gone_ = false;
  std::int64_t gone_ns_ = 0;
};

}  // namespace

int ServeTwin(const base::DeviceGeometry& device, const TwinOptions& options, int fd, double linger_s) {
  const std::string complaint = options.script.waypoints.empty() ? "" : CheckHandScript(options.script);
  if (!complaint.empty()) {
    std::fprintf(stderr, "twin: hand script %s: %s\n", options.script.name.c_str(), complaint.c_str());
    return 1;
  }
  int type = 0;
  socklen_t length = sizeof type;
  if (getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &length) != 0 || type != SOCK_SEQPACKET) {
    std::fprintf(stderr, "twin: descriptor %d is not a seqpacket socket: start the twin by omnid --device twin\n", fd);
    return 1;
  }
  std::unique_ptr<Recording> recording;
  if (!options.recording_path.empty()) {
    base::Result<std::unique_ptr<Recording>> opened = Recording::Open(options.recording_path);
    if (!opened) {
      std::fprintf(stderr, "twin: %s\n", opened.error().c_str());
      return 1;
    }
    recording = std::move(opened.value());
  }
  const StopSignals signals;
  if (options.real_time) RequestRealTime();
  Server(device, options, fd, std::move(recording)).Run(linger_s);
  return 0;
}

}  // namespace omni::sim
