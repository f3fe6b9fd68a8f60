#include "service/daemon/keys/key_thread.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/base/clock.h"

namespace omni::daemon {
namespace {

constexpr std::size_t kReadBytes = 64 * sizeof(input_event);

std::string RuleText(const config::KeyDeviceRule& rule) { return rule.path.empty() ? rule.name_glob : rule.path; }

}  // namespace

KeyThread::KeyThread(KeyThreadOptions options, std::unique_ptr<KeyPorts> ports, Changed changed)
    : options_(std::move(options)),
      ports_(std::move(ports)),
      changed_(std::move(changed)),
      book_(options_.codes),
      problems_(options_.devices.size()),
      wake_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (wake_ < 0) throw std::system_error(errno, std::generic_category(), "eventfd for the key thread");
  UpdateStatus();
  thread_ = std::thread([this] { Run(); });
}

KeyThread::~KeyThread() {
  const std::uint64_t one = 1;
  if (::write(wake_, &one, sizeof(one)) < 0) spdlog::error("keys: cannot wake the thread");
  thread_.join();
  for (const Port& port : open_) {
    if (port.fd >= 0) ::close(port.fd);
  }
  ::close(wake_);
}

std::vector<KeyThread::DeviceStatus> KeyThread::Status() const {
  const std::lock_guard lock(status_mutex_);
  return status_;
}

void KeyThread::Run() {
  std::int64_t next_search_ns = 0;
  for (;;) {
    const std::int64_t now_ns = base::MonotonicNow_ns();
    if (now_ns >= next_search_ns) {
      Search();
      next_search_ns = now_ns + std::int64_t{options_.search_ms} * 1'000'000;
    }
    std::array<pollfd, kMaxKeyDevicesOpen + 1> waits{};
    for (int i = 0; i < kMaxKeyDevicesOpen; ++i) waits[i] = {.fd = open_[i].fd, .events = POLLIN, .revents = 0};
    waits[kMaxKeyDevicesOpen] = {.fd = wake_, .events = POLLIN, .revents = 0};
    const std::int64_t left_ms = (next_search_ns - now_ns) / 1'000'000 + 1;
    if (::poll(waits.data(), waits.size(), static_cast<int>(left_ms)) < 0 && errno != EINTR) return;
    if (waits[kMaxKeyDevicesOpen].revents != 0) return;
    for (int i = 0; i < kMaxKeyDevicesOpen; ++i) {
      if (open_[i].fd >= 0 && waits[i].revents != 0) ReadPort(i);
    }
  }
}

// Opens the devices of a rule that are not open yet.
void KeyThread::Search() {
  for (std::size_t rule = 0; rule < options_.devices.size(); ++rule) {
    for (const std::string& path : ports_->FindDevices(options_.devices[rule])) {
      const bool known =
          std::any_of(open_.begin(), open_.end(), [&](const Port& port) { return port.fd >= 0 && port.path == path; });
      if (!known) OpenPort(rule, path);
    }
  }
  UpdateStatus();
}

void KeyThread::OpenPort(std::size_t rule, const std::string& path) {
  const auto free = std::find_if(open_.begin(), open_.end(), [](const Port& port) { return port.fd < 0; });
  if (free == open_.end()) {
    return Report(rule, path + ": is not read, the limit is " + std::to_string(kMaxKeyDevicesOpen) + " devices");
  }
  const base::Result<int> fd = ports_->Open(path, options_.devices[rule].grab);
  if (!fd.ok()) return Report(rule, fd.error());
  *free = {.fd = *fd, .rule = rule, .path = path, .decoder = {}};
  problems_[rule].clear();
  spdlog::info("keys: reading {}{}", path, options_.devices[rule].grab ? " (grabbed)" : "");
}

void KeyThread::ReadPort(int index) {
  Port& port = open_[index];
  std::array<unsigned char, kReadBytes> bytes;
  const ssize_t count = ::read(port.fd, bytes.data(), bytes.size());
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  if (count <= 0) return ClosePort(index);
  const std::int64_t now_ns = base::MonotonicNow_ns();
  bool changed = false;
  port.decoder.Feed(bytes.data(), static_cast<std::size_t>(count), now_ns,
                    [&](std::uint16_t code, bool down, std::int64_t t_ns) {
                      changed = book_.Set(index, code, down, t_ns) || changed;
                    });
  if (port.decoder.PopDropped()) RequestAllKeys(index, now_ns, changed);
  if (changed) changed_(book_.states());
}

void KeyThread::RequestAllKeys(int index, std::int64_t now_ns, bool& changed) {
  const auto down = ports_->KeysDown(open_[index].fd, book_.codes());
  for (std::size_t slot = 0; slot < book_.codes().size(); ++slot) {
    const bool is_down = down && (*down)[slot];
    changed = book_.Set(index, book_.codes()[slot], is_down, now_ns) || changed;
  }
}

// Unplugged, or at its end. Releases the keys that it held; the search finds it when it is back.
void KeyThread::ClosePort(int index) {
  Port& port = open_[index];
  ::close(port.fd);
  spdlog::warn("keys: {} was unplugged; it is read again once it is back", port.path);
  port = Port{};
  if (book_.ReleaseAll(index, base::MonotonicNow_ns())) changed_(book_.states());
  UpdateStatus();
}

void KeyThread::Report(std::size_t rule, const std::string& problem) {
  if (problems_[rule] == problem) return;
  problems_[rule] = problem;
  spdlog::warn("keys: {}", problem);
}

void KeyThread::UpdateStatus() {
  std::vector<DeviceStatus> status;
  for (std::size_t rule = 0; rule < options_.devices.size(); ++rule) {
    DeviceStatus row{.rule = RuleText(options_.devices[rule]), .paths = {}, .problem = problems_[rule]};
    for (const Port& port : open_) {
      if (port.fd >= 0 && port.rule == rule) row.paths += (row.paths.empty() ? "" : " ") + port.path;
    }
    status.push_back(std::move(row));
  }
  const std::lock_guard lock(status_mutex_);
  status_.swap(status);
}

}  // namespace omni::daemon
