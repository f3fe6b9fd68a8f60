// The one connection to omnid of an XrInstance: who may call what, and when.
//
// Poll and the sends take a mutex; Beat and reader() may be called from any thread at any time. Nothing blocks: every
// socket call below is non-blocking, and Poll gives way when another thread is already polling.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <vector>

#include "layer/src/log.h"
#include "service/client/connection.h"

namespace omni::layer {

// The pen as one xrSyncActions sees it.
struct PenSnapshot {
  bool present = false;
  std::uint64_t service_instance = 0;
  protocol::ToolSample sample;
  protocol::InputSnapshot inputs;
};

class ServiceLink {
 public:
  ServiceLink(client::ConnectionInfo info, Log& log);

  void Beat() noexcept { connection_.Beat(); }
  void Poll(std::int64_t now_ns);

  void SetSession(protocol::SessionState state);
  void Haptic(std::int64_t duration_ns, float amplitude, float frequency_Hz);
  void HapticStop();
  // False: not sent.
  bool Waveform(const protocol::Waveform& waveform, const std::vector<float>& samples);

  std::shared_ptr<const client::StateReader> reader() const;
  PenSnapshot Read(std::int64_t now_ns) const;

 private:
  void PublishReader();

  client::Connection connection_;
  Log& log_;
  std::mutex mutex_;  // of connection_ (except Beat) and of what follows
  protocol::SessionState session_ = protocol::SessionState::kNone;
  bool was_connected_ = false;
  std::string last_error_;
  std::atomic<std::int64_t> next_poll_ns_{0};

  mutable std::shared_mutex reader_mutex_;
  std::shared_ptr<const client::StateReader> reader_;
};

}  // namespace omni::layer
