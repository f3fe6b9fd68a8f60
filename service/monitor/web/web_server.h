// The page's server: files of the page by HTTP, and one WebSocket per open page, on the loopback address only. All on
// the thread that calls RunUntil. docs/protocol/page.md.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::monitor {

using PageId = std::uint64_t;  // never 0, never reused

// Whole messages, as they come. Called by RunUntil.
class WebHandler {
 public:
  virtual ~WebHandler() = default;
  virtual void OnPage(PageId page) = 0;
  virtual void OnText(PageId page, std::string_view text) = 0;
  virtual void OnBytes(PageId page, std::string_view bytes) = 0;
  virtual void OnPageGone(PageId page) = 0;
  // The body of GET /hello, JSON.
  virtual std::string HelloJson() = 0;
};

struct WebOptions {
  std::uint16_t port = 0;  // 0: any that is free
  std::string token;
  std::string code;           // good once, for the token: it may stand in the command line of a browser. Empty: none
  std::optional<uid_t> user;  // whose connections are served, and root's; none: this process's
  std::string folder;         // of the page's files
  std::size_t max_pages = 20;
  std::size_t max_message_bytes = 64 << 10;  // that a page may send
};

// Close codes of ours (RFC 6455, 7.4.2: 4000 to 4999), with a reason for the person.
enum class CloseCode : std::uint16_t { kTooSlow = 4001, kBadMessage = 4002, kEnds = 4003 };

class WebServer {
 public:
  // The error names the port and what to do.
  static base::Result<std::unique_ptr<WebServer>> Listen(const WebOptions& options, WebHandler& handler);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  std::uint16_t port() const;

  // Serves until this time of CLOCK_MONOTONIC.
  void RunUntil(std::int64_t t_ns);

  // Queues a message; the page gets messages in the order of the calls. A page with more than kMaxUnsentBytes waiting
  // is closed as too slow. Unknown pages are ignored.
  static constexpr std::size_t kMaxUnsentBytes = 256u << 20;
  void Send(PageId page, std::shared_ptr<const std::string> message, bool binary);
  // Nothing waits to be sent: the moment for what is only worth sending while it is new.
  bool IsIdle(PageId page) const;
  void Close(PageId page, CloseCode code, std::string_view reason);

  std::uint64_t bytes_sent() const;  // of messages

 private:
  struct Impl;
  explicit WebServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace omni::monitor
