// One running omni-builder: started, limited, talked to, and ended with an account of how it ended.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/builder/messages.h"
#include "service/daemon/scenes/build_way.h"

namespace omni::daemon {

// It ended early, misbehaved, or its build was cancelled: an error in words, or none if it was cancelled.
struct BuilderEnded {
  std::string why;
};

class BuilderProcess {
 public:
  // Throws BuilderEnded. `cancel` outlives this.
  BuilderProcess(const std::string& program, const CancelEvent& cancel);
  ~BuilderProcess();  // kills it
  BuilderProcess(const BuilderProcess&) = delete;
  BuilderProcess& operator=(const BuilderProcess&) = delete;

  // What it may use from now on, beside what every process has. Throws BuilderEnded.
  void Limit(std::uint64_t bytes);

  template <class M>
  void Send(const M& message, std::string_view text = {}, const std::vector<int>& fds = {}) {
    std::string bytes(reinterpret_cast<const char*>(&message), sizeof message);
    SendBytes(bytes.append(text), fds);
  }

  // The next message; waits for it as long as the builder works. Throws BuilderEnded.
  struct Message {
    builder::Kind kind{};
    std::string bytes;
    // Throws BuilderEnded when it is not as long as M and its text, if it has one.
    template <class M>
    M ReadAs(std::string* text = nullptr) const {
      M message;
      if (bytes.size() < sizeof message || (text == nullptr && bytes.size() != sizeof message)) ThrowMisshapen();
      std::memcpy(&message, bytes.data(), sizeof message);
      if (text != nullptr) *text = bytes.substr(sizeof message);
      return message;
    }
    [[noreturn]] static void ThrowMisshapen();
  };
  Message Receive();

  // It has done its work: nothing can change what it has written any more.
  void End();

 private:
  void SendBytes(const std::string& bytes, const std::vector<int>& fds);
  // Waits for an event on the socket, for cancel, or until the builder no longer works.
  void Wait(short event);
  bool HasWorked();
  [[noreturn]] void ThrowHowItEnded();
  int WaitForEnd();

  const CancelEvent& cancel_;
  base::UniqueFd socket_;
  pid_t pid_ = -1;
  std::uint64_t limit_bytes_ = 0;
  std::int64_t cpu_ns_ = 0;  // it had used when it was last looked at
  std::uint64_t oom_kills_;
};

}  // namespace omni::daemon
