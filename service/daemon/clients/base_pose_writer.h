// Writes alignments to disk without waiting for it, and replies to the requesting client once its change is written.
// Control thread only.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "service/daemon/clients/base_poses.h"
#include "service/daemon/file_writer.h"

namespace omni::daemon {

class BasePoseWriter {
 public:
  using Reply = std::function<void(ipc::ClientId, std::uint32_t number, bool done, const std::string& text)>;
  explicit BasePoseWriter(Reply reply);

  BasePoses::Write write();
  // After BasePoses::Do: replies at once, or when its change is written.
  void Answer(ipc::ClientId id, std::uint32_t number, const BasePoses::Done& done);
  // Once per period: handles completed writes.
  void HandleWritten(BasePoses& base_poses);

 private:
  struct LateReply {
    std::uint64_t written = 0;  // number of the write
    ipc::ClientId id = 0;
    std::uint32_t number = 0;
    std::string text;
  };

  const Reply reply_;
  FileWriter writer_;
  std::uint64_t requested_ = 0, written_ = 0;  // newest numbers of the writer's
  std::vector<LateReply> late_;
};

}  // namespace omni::daemon
