// Writer of the state memory. Created by the control thread, written by the tick thread: plain atomic stores,
// no system call, no allocation, no lock.
#pragma once

#include <cstdint>
#include <memory>

#include "service/base/result.h"
#include "service/protocol/state_memory.h"

namespace omni::ipc {

class StatePublisher {
 public:
  // Makes the memfd, maps it for writing, then seals it FUTURE_WRITE | SHRINK | GROW | SEAL.
  static base::Result<std::unique_ptr<StatePublisher>> Create(std::uint64_t service_instance);
  ~StatePublisher();
  StatePublisher(const StatePublisher&) = delete;
  StatePublisher& operator=(const StatePublisher&) = delete;

  // Tick thread only.
  void Publish(const protocol::ToolSample& sample, const protocol::InputSnapshot& inputs) noexcept;

  int fd() const { return fd_; }  // to be passed to clients; stays ours

 private:
  StatePublisher(int fd, protocol::StateMemory* memory) : fd_(fd), memory_(memory) {}
  int fd_;
  protocol::StateMemory* memory_;
};

}  // namespace omni::ipc
