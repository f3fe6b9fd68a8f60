// One connected process, as the control thread knows it.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "service/base/result.h"
#include "service/base/sealed_memory.h"
#include "service/ipc/server.h"
#include "service/protocol/packet_socket.h"
#include "service/protocol/state_memory.h"

namespace omni::ipc {

struct Credentials {
  uid_t uid = static_cast<uid_t>(-1);
  pid_t pid = 0;  // 0: in no pid namespace that we can see
};
Credentials CredentialsOf(int socket) noexcept;

// A descriptor that becomes readable when the process ends.
struct ProcessWatch {
  base::UniqueFd fd;    // may be absent where the kernel offers none: then only the socket shows the end
  base::UniqueFd stat;  // the process's line in /proc; may be absent
  bool already_dead = false;
};
ProcessWatch WatchProcess(int socket, pid_t pid) noexcept;

// Whether a line of /proc/PID/task/PID/stat [proc_pid_stat(5)] is of a process that has been killed. It shows that at
// once; the end itself shows only when the process gets a processor to end on, which busy programs delay.
bool IsEnding(std::string_view stat) noexcept;

class Peer {
 public:
  Peer(ClientId id, base::UniqueFd socket, ProcessWatch process, pid_t pid, std::int64_t now_ns);

  ClientId id() const noexcept { return info_.id; }
  int socket() const noexcept { return socket_.get(); }
  int process() const noexcept { return process_.fd.get(); }
  const ClientInfo& info() const noexcept { return info_; }
  std::int64_t accepted_ns() const noexcept { return accepted_ns_; }
  bool greeted() const noexcept { return life_ != nullptr; }
  bool doomed() const noexcept { return doomed_; }
  // Null before it is greeted. A holder keeps the page mapped after the peer has gone.
  const std::shared_ptr<const protocol::LifePage>& life() const noexcept { return life_; }
  std::uint64_t dropped() const noexcept { return dropped_; }

  // Makes the life page and sends Welcome. From here on the peer is a client.
  base::Status Greet(const protocol::Hello& hello, std::uint64_t service_instance, int state_fd);

  // Non-blocking. False: the peer's socket is full, or it is gone (and doomed). A message of Delivery::kOnce is then
  // lost, and counted. `file`: descriptor to pass along, still owned by the caller; < 0: none.
  bool Send(std::string_view message, int file, protocol::Delivery delivery) noexcept;

  // Asks /proc, which involves no disk: some 30 us.
  bool IsKilled() const noexcept;

  // Marks it for removal at the end of this round. A reason is sent to it first.
  void Doom(const std::string& reason) noexcept;

 private:
  ClientInfo info_;
  base::UniqueFd socket_;
  ProcessWatch process_;
  std::shared_ptr<const protocol::LifePage> life_;
  std::int64_t accepted_ns_;
  std::uint64_t dropped_ = 0;
  bool doomed_ = false;
};

// Best effort: the peer may be gone or not reading.
void SendReject(int socket, const std::string& reason) noexcept;

// Log lines with a limit, against floods by a misbehaving client: a line that was just written is not written again.
class LogLines {
 public:
  explicit LogLines(std::function<void(const std::string&)> sink);  // empty: standard error
  void Write(const std::string& line, std::int64_t now_ns);

 private:
  std::function<void(const std::string&)> sink_;
  std::string last_line_;
  std::int64_t last_ns_ = 0;
  std::int64_t window_start_ns_ = 0;
  int lines_in_window_ = 0;
};

}  // namespace omni::ipc
