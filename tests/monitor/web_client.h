// A browser's end of HTTP and WebSocket by hand, so that a test can also send what no browser would.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "service/base/unique_fd.h"

namespace omni::monitor::test {

class WebClient {
 public:
  // Connected to this port of 127.0.0.1. `pump` is called while it waits: the server has no thread of its own.
  WebClient(std::uint16_t port, std::function<void()> pump);

  void Send(std::string_view bytes);
  // What has come until the server closes, or has nothing more to say for a while.
  std::string ReadAll();
  // A whole HTTP answer: up to the end of its header, or of its body.
  std::string Get(const std::string& target, const std::string& headers);
  // The status line of an attempt to open a WebSocket.
  std::string Upgrade(const std::string& target, const std::string& headers);

  // After an accepted Upgrade.
  void SendFrame(unsigned opcode, std::string_view payload, bool masked = true);
  struct Frame {
    unsigned opcode = 0;  // 0: none came
    std::string payload;
  };
  Frame ReadFrame();

  bool closed() const { return closed_; }

 private:
  bool Receive();

  base::UniqueFd socket_;
  std::function<void()> pump_;
  std::string received_;
  bool closed_ = false;
};

}  // namespace omni::monitor::test
