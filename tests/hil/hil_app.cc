// hil_app NAME: an application that is focused and alive until it is ended (omni_hil [options] -- omnid ... -- hil_app
// NAME). It finds the service like any other application.
#include <chrono>
#include <cstdio>
#include <thread>

#include "service/base/clock.h"
#include "service/client/connection.h"

namespace {

constexpr std::chrono::milliseconds kFrame{5};
constexpr std::int64_t kRetry_ns = 50'000'000;

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: hil_app NAME\n");
    return 2;
  }
  omni::client::Connection connection(
      {.application = argv[1], .engine = "", .socket_path = "", .retry_interval_ns = kRetry_ns});
  bool focused = false;  // a new connection is notified automatically
  for (;;) {
    connection.Poll(omni::base::MonotonicNow_ns());
    connection.SignalAlive();
    if (connection.connected() && !focused) {
      focused = connection.SendSession(omni::protocol::SessionState::kBegun) &&
                connection.SendSession(omni::protocol::SessionState::kFocused);
    }
    std::this_thread::sleep_for(kFrame);
  }
}
