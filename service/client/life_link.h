// The client's side of its life page. The page keeps one address for as long as the link lives: private memory while
// not connected, the service's page while connected. So SignalAlive() may run on any thread while another one
// (re)connects.
#pragma once

#include <string>

#include "service/base/clock.h"
#include "service/protocol/state_memory.h"

namespace omni::client {

class LifeLink {
 public:
  LifeLink();
  ~LifeLink();
  LifeLink(const LifeLink&) = delete;
  LifeLink& operator=(const LifeLink&) = delete;

  // Checks seals and size of `fd`, then puts it in place. Returns the problem; empty: done. `fd` stays the caller's.
  std::string Attach(int fd);
  void Detach() noexcept;

  void SignalAlive() noexcept { page_->SignalAlive(base::MonotonicNow_ns()); }

 private:
  protocol::LifePage* page_;
  protocol::LifePage fallback_;  // if no page of memory can be mapped
};

}  // namespace omni::client
