// Where the base stands in the spaces of connected applications: the file, the clients that requested a base pose, and
// the notification of changes. Builds of one runtime share an alignment (config/runtime_identity.h). Control thread
// only.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "service/alignment/types.h"
#include "service/config/files/alignment_file.h"
#include "service/config/text/text_file.h"
#include "service/daemon/file_writer.h"
#include "service/ipc/server.h"
#include "service/protocol/base_pose.h"

namespace omni::daemon {

alignment::Rigid ToRigid(const protocol::WirePose& pose);
protocol::WirePose ToWire(const alignment::Rigid& pose);

class BasePoses {
 public:
  // Writes the file. Ok: it is written, or queued; then Written reports the result.
  using Write = std::function<base::Status(const std::string& path, const std::string& text)>;
  // Reads the file; an empty path: nothing is stored. A file that cannot be read is never overwritten.
  explicit BasePoses(std::string path, Write write = config::WriteTextFile);

  // With an alignment that no application has used for kHeadsetPause_s, the headset counts as started since.
  void HandleRequest(ipc::ClientId id, const protocol::BasePoseRequest& request, std::int64_t now_unix_s);
  void Remove(ipc::ClientId id, std::int64_t now_unix_s);
  // A change of a space that this client has requested. The same change reported by several applications counts once.
  // An implausible one leaves the alignment where it is, but doubtful. `now_ns`: CLOCK_MONOTONIC.
  void HandleSpaceChange(ipc::ClientId id, const protocol::SpaceChange& change, std::int64_t now_ns);

  // Once a second, while it is known: the uniform field about the base. A base that is turned, or carried to where iron
  // bends the earth's field otherwise, sees another one: the alignments measured before are doubtful until the field is
  // back. Moving it along the desk changes nothing that can be seen.
  static constexpr double kMoved_T = 15e-6;  // 20 degrees in 45 uT; more than what is laid on a desk adds
  static constexpr double kBack_T = 1.5e-6;  // 2 degrees
  static constexpr int kMoved_s = 5;         // in a row, either way
  static constexpr double kSteady_T = 3e-6;  // of a field that is kept with an alignment ...
  static constexpr int kSteady_s = 20;  // ... once it was steady for so long: a controller is near while one aligns
  // A base that moves sees another field at each place: nothing is concluded from it.
  void UpdateField(const base::Vec3& field_base_T);

  // The headset in whose spaces the base moves; without names: any; none: it stands where it was measured.
  // `seen`: where it is now is known.
  void SetFollowed(const std::optional<protocol::HeadsetNames>& headset, bool seen);

  struct Done {
    bool ok = false;
    std::string text;  // for people
  };
  Done Execute(const protocol::BasePoseCommand& command, std::int64_t now_unix_s);

  // Result of a queued write. If it failed, the change is used until omnid ends.
  void Written(const base::Status& status) { problem_ = status.ok() ? std::string() : status.error(); }

  // Notifies every client of changes. If `send` returns false, the next call tries again.
  void Notify(const std::function<bool(ipc::ClientId, const protocol::BasePose&)>& send);

  // This client's spaces have a measured, undoubted base pose, or it is known how the base moves in them.
  bool IsAligned(ipc::ClientId id) const;
  // The request of this client; null: none yet.
  const protocol::BasePoseRequest* RequestOf(ipc::ClientId id) const;
  const config::AlignmentFile& file() const { return file_; }
  const std::string& path() const { return path_; }
  // Why the file is not used or could not be written; empty: nothing is wrong.
  const std::string& problem() const { return problem_; }

 private:
  struct Live {  // of file_.entries, same index
    std::int64_t changes_until_ns = 0;
    std::uint64_t revision = 0;
    int field_s = 0;  // that the field has spoken against `base_moved`
  };
  struct Client {
    protocol::BasePoseRequest request;
    bool reported = false;
  };
  int Find(const protocol::HeadsetNames& headset, std::int32_t space) const;  // index; -1: none
  int FindToMove(ipc::ClientId id, std::int32_t space) const;
  void Doubt(std::size_t index);
  void KeepNewestOfEach();
  int FindFor(const protocol::BasePoseRequest& request) const;
  bool Follows(const protocol::BasePoseRequest& request) const;
  void Changed(std::size_t index);
  bool CountStart(config::AlignmentEntry& entry, std::int64_t now_unix_s) const;
  base::Status Save();
  Done Store(const protocol::BasePoseCommand& command, std::int64_t now_unix_s);
  Done Forget(const protocol::BasePoseCommand& command);
  Done Restore(const protocol::BasePoseCommand& command);
  Done Check(const protocol::BasePoseCommand& command, std::int64_t now_unix_s);
  Done SetPolicy(const protocol::BasePoseCommand& command);
  void NotifyAll();

  std::string path_;
  Write write_;
  std::string problem_;
  bool readable_ = true;
  config::AlignmentFile file_;
  std::vector<Live> live_;
  std::map<ipc::ClientId, Client> clients_;
  std::uint64_t revisions_ = 0;
  std::optional<protocol::HeadsetNames> followed_;
  bool followed_seen_ = false;
  base::Vec3 steady_field_T_;
  int steady_s_ = 0;
};

// Writes alignments to disk without waiting for it, and replies to the requesting client once its change is written.
// Control thread only.
class BasePoseWriter {
 public:
  using Reply = std::function<void(ipc::ClientId, std::uint32_t number, bool done, const std::string& text)>;
  explicit BasePoseWriter(Reply reply);

  BasePoses::Write write();
  // After BasePoses::Do: replies at once, or when its change is written.
  void ReplyWhenWritten(ipc::ClientId id, std::uint32_t number, const BasePoses::Done& done);
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
