#include "service/daemon/clients/base_pose_writer.h"

#include <utility>

#include <spdlog/spdlog.h>

#include "service/config/text/text_file.h"

namespace omni::daemon {

BasePoseWriter::BasePoseWriter(Reply reply) : reply_(std::move(reply)), writer_(config::WriteTextFile) {}

BasePoses::Write BasePoseWriter::write() {
  return [this](const std::string& path, const std::string& text) {
    requested_ = writer_.Request(path, text);
    return base::Status(base::Ok{});
  };
}

void BasePoseWriter::Answer(ipc::ClientId id, std::uint32_t number, const BasePoses::Done& done) {
  if (!done.ok || written_ == requested_) return reply_(id, number, done.ok, done.text);
  late_.push_back({requested_, id, number, done.text});  // it is true once the file is written
}

void BasePoseWriter::HandleWritten(BasePoses& base_poses) {
  while (const std::optional<FileWriter::Written> written = writer_.PopWritten()) {
    const base::Status& status = written->status;
    written_ = written->number;
    if (!status.ok() && status.error() != base_poses.problem()) spdlog::warn("{}", status.error());
    base_poses.Written(status);
    std::erase_if(late_, [&](const LateReply& late) {
      if (late.written > written->number) return false;
      reply_(late.id, late.number, status.ok(),
             status.ok() ? late.text : status.error() + " (used until omnid ends, then lost)");
      return true;
    });
  }
}

}  // namespace omni::daemon
