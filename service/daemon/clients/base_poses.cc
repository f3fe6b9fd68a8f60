#include "service/daemon/clients/base_poses.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string_view>
#include <utility>

#include <spdlog/spdlog.h>

#include "service/alignment/rigid.h"
#include "service/config/runtime_identity.h"
#include "service/config/text/text_file.h"
#include "service/protocol/text.h"

namespace omni::daemon {
namespace {

constexpr std::int64_t kFarthestChange_ns = 10'000'000'000;  // runtimes announce changes some frames ahead

std::string IsoDate(std::int64_t unix_s) {
  const auto seconds = static_cast<std::time_t>(unix_s);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

// 0: no date.
std::int64_t UnixSeconds(const std::string& date) {
  std::tm utc{};
  const char* end = ::strptime(date.c_str(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return end == nullptr || *end != '\0' ? 0 : static_cast<std::int64_t>(::timegm(&utc));
}

alignment::Rigid PoseOf(const config::AlignmentEntry& entry) {
  return {.orientation = entry.orientation_space, .position_m = entry.position_space_m};
}

alignment::Rigid MeasuredPoseOf(const config::AlignmentEntry& entry) {
  return {.orientation = entry.measured_orientation_space, .position_m = entry.measured_position_space_m};
}

void SetPose(const alignment::Rigid& pose, config::AlignmentEntry& entry) {
  entry.orientation_space = pose.orientation;
  entry.position_space_m = pose.position_m;
}

// Names from other programs, fit for a TOML string: never empty, no control characters.
std::string NameOrUnnamed(const char* name) {
  std::string text = protocol::Printable(name);
  return text.empty() ? "unnamed" : text;
}

bool InReach(const alignment::Rigid& pose) {
  const auto within = [](double x) { return x >= -protocol::kFarthestBase_m && x <= protocol::kFarthestBase_m; };
  return within(pose.position_m.x) && within(pose.position_m.y) && within(pose.position_m.z);
}

// The space's "up", seen from the base: turning about it changes nothing.
base::Vec3 UpInBase(const alignment::Rigid& X_LB) {
  return alignment::TransformPoint({.orientation = alignment::Inverse(X_LB).orientation, .position_m = {}}, {0, 1, 0});
}

// Against the pose as measured, so that many small steps lead no further than one.
bool IsRecentring(const alignment::Rigid& measured, const alignment::Rigid& moved) {
  const base::Vec3 a = UpInBase(measured), b = UpInBase(moved);
  const double cosine = Dot(a, b);
  return InReach(moved) && alignment::Distance_m(measured, moved, {}) <= protocol::kFarthestRecentring_m &&
         cosine >= std::cos(protocol::kMostRecentringTilt_rad);
}

// What was learned of the headset outlives a measurement.
config::AlignmentDrift Fresh(config::AlignmentDrift drift) {
  drift.starts = 0;
  drift.checked_m = 0;
  return drift;
}

// Of an AlignmentEntry or of protocol::HeadsetNames.
template <class Names>
bool SameNames(const Names& a, const Names& b) {
  return std::string_view(a.system) == b.system &&
         config::RuntimeIdentity(a.runtime) == config::RuntimeIdentity(b.runtime);
}

bool SameHeadset(const config::AlignmentEntry& a, const config::AlignmentEntry& b) {
  return a.space == b.space && SameNames(a, b);
}

}  // namespace

alignment::Rigid ToRigid(const protocol::WirePose& pose) {
  const auto& q = pose.orientation_wxyz;
  const auto& p = pose.position_m;
  return {.orientation = {q[0], q[1], q[2], q[3]}, .position_m = {p[0], p[1], p[2]}};
}

protocol::WirePose ToWire(const alignment::Rigid& pose) {
  const base::Quat& q = pose.orientation;
  const base::Vec3& p = pose.position_m;
  return {.position_m = {p.x, p.y, p.z}, .orientation_wxyz = {q.w, q.x, q.y, q.z}};
}

BasePoses::BasePoses(std::string path, Write write) : path_(std::move(path)), write_(std::move(write)) {
  if (path_.empty()) return;
  auto loaded = config::LoadAlignmentFile(path_);
  if (loaded.ok()) {
    file_ = std::move(*loaded);
  } else {
    readable_ = false;
    problem_ = loaded.error() + " (not used and not overwritten)";
  }
  KeepNewestOfEach();
  live_.resize(file_.entries.size());
}

// Older files may have an entry for every build of a runtime.
void BasePoses::KeepNewestOfEach() {
  std::vector<config::AlignmentEntry> kept;
  for (config::AlignmentEntry& entry : file_.entries) {
    const auto same =
        std::find_if(kept.begin(), kept.end(), [&](const auto& other) { return SameHeadset(entry, other); });
    if (same == kept.end()) {
      kept.push_back(std::move(entry));
    } else if (entry.date >= same->date) {  // ISO 8601
      *same = std::move(entry);
    }
  }
  file_.entries = std::move(kept);
}

int BasePoses::Find(const protocol::HeadsetNames& headset, std::int32_t space) const {
  const config::AlignmentEntry wanted{
      .runtime = NameOrUnnamed(headset.runtime), .system = NameOrUnnamed(headset.system), .space = space};
  const auto found = std::find_if(file_.entries.begin(), file_.entries.end(),
                                  [&](const auto& entry) { return SameHeadset(entry, wanted); });
  return found == file_.entries.end() ? -1 : static_cast<int>(found - file_.entries.begin());
}

int BasePoses::FindToMove(ipc::ClientId id, std::int32_t space) const {
  const protocol::BasePoseRequest* request = RequestOf(id);
  if (request == nullptr) return -1;
  const auto end = request->spaces.begin() + request->space_count;
  return std::find(request->spaces.begin(), end, space) == end ? -1 : Find(request->headset, space);
}

int BasePoses::FindFor(const protocol::BasePoseRequest& request) const {
  for (std::uint32_t i = 0; i < request.space_count; ++i) {
    if (const int found = Find(request.headset, request.spaces[i]); found >= 0) return found;
  }
  return -1;
}

void BasePoses::HandleRequest(ipc::ClientId id, const protocol::BasePoseRequest& request, std::int64_t now_unix_s) {
  clients_.erase(id);
  if (const int found = FindFor(request); found >= 0) {
    config::AlignmentEntry& entry = file_.entries[static_cast<std::size_t>(found)];
    const bool in_use = std::any_of(clients_.begin(), clients_.end(),
                                    [&](const auto& client) { return FindFor(client.second.request) == found; });
    if (!in_use && CountStart(entry, now_unix_s)) {
      Changed(static_cast<std::size_t>(found));
      (void)Save();
    }
  }
  clients_[id] = {.request = request, .reported = false};
}

void BasePoses::Remove(ipc::ClientId id, std::int64_t now_unix_s) {
  const auto client = clients_.find(id);
  if (client == clients_.end()) return;
  const int found = FindFor(client->second.request);
  clients_.erase(client);
  if (found < 0) return;
  file_.entries[static_cast<std::size_t>(found)].used = IsoDate(now_unix_s);
  (void)Save();
}

bool BasePoses::CountStart(config::AlignmentEntry& entry, std::int64_t now_unix_s) const {
  const std::int64_t idle_s = now_unix_s - UnixSeconds(entry.used.empty() ? entry.date : entry.used);
  if (idle_s >= 0 && idle_s < config::kHeadsetPause_s) return false;
  ++entry.drift.starts;
  entry.used = IsoDate(now_unix_s);
  return true;
}

void BasePoses::NotifyAll() {
  for (auto& [id, client] : clients_) client.reported = false;
}

void BasePoses::Changed(std::size_t index) {
  live_[index].revision = ++revisions_;
  NotifyAll();
}

// X_newB = (X_prev_new)^-1 X_prevB
void BasePoses::HandleSpaceChange(ipc::ClientId id, const protocol::SpaceChange& change, std::int64_t now_ns) {
  const int found = FindToMove(id, change.space);
  if (found < 0) return;
  const auto index = static_cast<std::size_t>(found);
  // A time in the far future comes from a broken clock; accepted, it would hide all changes until then.
  const std::int64_t changes_at_ns = std::min(change.changes_at_ns, now_ns + kFarthestChange_ns);
  if (changes_at_ns <= live_[index].changes_until_ns + protocol::kSameChange_ns && live_[index].changes_until_ns != 0) {
    return;
  }
  config::AlignmentEntry& entry = file_.entries[index];
  const alignment::Rigid moved = alignment::Compose(alignment::Inverse(ToRigid(change.new_in_previous)), PoseOf(entry));
  if (change.pose_valid == 1 && !IsRecentring(MeasuredPoseOf(entry), moved)) return Doubt(index);
  live_[index].changes_until_ns = changes_at_ns;
  if (change.pose_valid == 1) {
    SetPose(moved, entry);
  } else {
    entry.doubtful = true;
  }
  ++entry.recentred;
  live_[index].revision = ++revisions_;
  (void)Save();  // connected applications received the change themselves; a failure is in problem()
}

// Connected applications have moved the base as their runtime reported: they are notified to revert that.
void BasePoses::Doubt(std::size_t index) {
  if (file_.entries[index].doubtful) return;
  file_.entries[index].doubtful = true;
  Changed(index);
  (void)Save();
}

void BasePoses::SetFollowed(const std::optional<protocol::HeadsetNames>& headset, bool seen) {
  followed_seen_ = seen;
  if (headset.has_value() == followed_.has_value() && (!headset || SameNames(*headset, *followed_))) return;
  followed_ = headset;
  steady_s_ = 0;
  NotifyAll();
}

bool BasePoses::Follows(const protocol::BasePoseRequest& request) const {
  return followed_ && (followed_->runtime[0] == '\0' || SameNames(request.headset, *followed_));
}

void BasePoses::UpdateField(const base::Vec3& field_base_T) {
  if (followed_) return;
  const bool same = base::Distance(field_base_T, steady_field_T_) < kSteady_T;
  steady_s_ = same ? steady_s_ + 1 : 0;
  if (!same) steady_field_T_ = field_base_T;
  bool changed = false;
  for (std::size_t i = 0; i < file_.entries.size(); ++i) {
    config::AlignmentEntry& entry = file_.entries[i];
    if (!entry.field_base_T) {
      if (steady_s_ < kSteady_s) continue;
      entry.field_base_T = field_base_T;
      changed = true;
      continue;
    }
    const double change_T = base::Distance(field_base_T, *entry.field_base_T);
    const bool moved = change_T > (entry.base_moved ? kBack_T : kMoved_T);
    live_[i].field_s = moved != entry.base_moved ? live_[i].field_s + 1 : 0;
    if (live_[i].field_s < kMoved_s) continue;
    live_[i].field_s = 0;
    entry.base_moved = moved;
    changed = true;
    Changed(i);
  }
  if (changed) (void)Save();
}

base::Status BasePoses::Save() {
  if (!readable_) return base::Error{problem_ + "; correct the file or move it away, then restart omnid"};
  if (path_.empty()) return base::Error{"omnid has no home folder to keep alignments in; set XDG_CONFIG_HOME"};
  base::Status saved = write_(path_, config::WriteAlignments(file_));
  if (!saved.ok()) problem_ = saved.error();
  return saved;
}

BasePoses::Done BasePoses::Store(const protocol::BasePoseCommand& command, std::int64_t now_unix_s) {
  if (!readable_) return {false, Save().error()};
  int found = Find(command.headset, command.space);
  const config::AlignmentFile before = file_;
  if (found < 0) {
    if (file_.entries.size() >= config::kMaxAlignments) {
      return {false, path_ + ": has " + std::to_string(config::kMaxAlignments) +
                         " alignments, the limit; remove some: omni align --forget"};
    }
    found = static_cast<int>(file_.entries.size());
    file_.entries.emplace_back();
    live_.emplace_back();
  }
  config::AlignmentEntry& entry = file_.entries[static_cast<std::size_t>(found)];
  entry = {.runtime = NameOrUnnamed(command.headset.runtime),
           .system = NameOrUnnamed(command.headset.system),
           .space = command.space,
           .method = NameOrUnnamed(command.method),
           .date = IsoDate(now_unix_s),
           .samples = static_cast<int>(std::min<std::uint32_t>(command.samples, 1'000'000)),
           .rms_mm = 1e3 * command.rms_m,
           .expected_error_mm = 1e3 * command.expected_error_m,
           .rotation_deg = std::min(180.0, 57.29577951308232 * command.rotation_sigma_rad),
           .drift = Fresh(entry.drift)};
  SetPose(alignment::Compose(ToRigid(command.base_space), {}), entry);  // the quaternion to unit length
  entry.measured_orientation_space = entry.orientation_space;
  entry.measured_position_space_m = entry.position_space_m;
  steady_s_ = 0;
  Changed(static_cast<std::size_t>(found));
  if (auto saved = Save(); !saved.ok()) {
    file_ = before;
    live_.resize(file_.entries.size());
    NotifyAll();
    return {false, saved.error()};
  }
  return {true, path_};
}

BasePoses::Done BasePoses::Forget(const protocol::BasePoseCommand& command) {
  if (!readable_) return {false, Save().error()};
  const config::AlignmentFile before = file_;
  const std::vector<Live> live_before = live_;
  const bool all = command.headset.runtime[0] == '\0';
  const int only = all ? -1 : Find(command.headset, command.space);
  if (all ? file_.entries.empty() : only < 0) return {false, "no such alignment is stored; see omni align --show"};
  const std::size_t count = all ? file_.entries.size() : 1;
  const auto at = all ? 0 : static_cast<std::ptrdiff_t>(only);
  file_.entries.erase(file_.entries.begin() + at, file_.entries.begin() + at + static_cast<std::ptrdiff_t>(count));
  live_.erase(live_.begin() + at, live_.begin() + at + static_cast<std::ptrdiff_t>(count));
  NotifyAll();
  if (auto saved = Save(); !saved.ok()) {
    file_ = before;
    live_ = live_before;
    return {false, saved.error()};
  }
  return {true, std::to_string(count) + (count == 1 ? " alignment forgotten" : " alignments forgotten")};
}

BasePoses::Done BasePoses::Restore(const protocol::BasePoseCommand& command) {
  if (!readable_) return {false, Save().error()};
  const int found = Find(command.headset, command.space);
  if (found < 0) return {false, "no such alignment is stored; see omni align --show"};
  config::AlignmentEntry& entry = file_.entries[static_cast<std::size_t>(found)];
  if (entry.recentred == 0 && entry.IsTrusted()) return {false, "its space has not moved since it was measured"};
  const config::AlignmentEntry before = entry;
  SetPose(MeasuredPoseOf(entry), entry);
  entry.recentred = 0;
  entry.doubtful = entry.base_moved = false;
  entry.drift = Fresh(entry.drift);
  entry.field_base_T.reset();  // the base stands where it stood, says who restores it
  steady_s_ = 0;
  Changed(static_cast<std::size_t>(found));
  if (auto saved = Save(); !saved.ok()) {
    entry = before;
    return {false, saved.error()};
  }
  return {true, "restored as measured on " + entry.date};
}

BasePoses::Done BasePoses::Check(const protocol::BasePoseCommand& command, std::int64_t now_unix_s) {
  if (!readable_) return {false, Save().error()};
  const int found = Find(command.headset, command.space);
  if (found < 0) return {false, "no such alignment is stored; measure one: omni align"};
  config::AlignmentEntry& entry = file_.entries[static_cast<std::size_t>(found)];
  const config::AlignmentEntry before = entry;
  const alignment::Rigid there{.orientation = entry.orientation_space,
                               .position_m = ToRigid(command.base_space).position_m};
  const double offset_m = base::Distance(there.position_m, entry.position_space_m);
  const bool correct = command.correct == 1;
  if (correct && !IsRecentring(MeasuredPoseOf(entry), there)) {
    return {false, "the base is too far from where it was measured; measure it again: omni align"};
  }
  CountStart(entry, now_unix_s);
  entry.used = IsoDate(now_unix_s);
  entry.drift = config::DriftAfterCheck(entry.drift, offset_m, 1e-3 * entry.expected_error_mm, correct);
  if (correct) {
    SetPose(there, entry);
    ++entry.recentred;
    entry.doubtful = false;
  }
  Changed(static_cast<std::size_t>(found));
  if (auto saved = Save(); !saved.ok()) {
    entry = before;
    return {false, saved.error()};
  }
  char text[160];
  std::snprintf(text, sizeof text, "%.1f mm from where it is stored; %s", 1e3 * offset_m,
                correct             ? "corrected, and running applications use it already"
                : entry.IsTrusted() ? "running applications go on with it"
                                    : "running applications no longer call the pen tracked");
  return {true, text};
}

BasePoses::Done BasePoses::Execute(const protocol::BasePoseCommand& command, std::int64_t now_unix_s) {
  switch (command.action) {
    case protocol::BasePoseAction::kStore:
      return Store(command, now_unix_s);
    case protocol::BasePoseAction::kForget:
      return Forget(command);
    case protocol::BasePoseAction::kRestore:
      return Restore(command);
    case protocol::BasePoseAction::kCheck:
      return Check(command, now_unix_s);
    case protocol::BasePoseAction::kPolicy:
      return SetPolicy(command);
  }
  return {false, "an unknown action"};
}

BasePoses::Done BasePoses::SetPolicy(const protocol::BasePoseCommand& command) {
  const config::UncalibratedPolicy before = file_.uncalibrated;
  file_.uncalibrated = static_cast<config::UncalibratedPolicy>(command.uncalibrated);
  NotifyAll();
  if (auto saved = Save(); !saved.ok()) {
    file_.uncalibrated = before;
    return {false, saved.error()};
  }
  return {true, std::string("placement = \"") + config::PolicyName(file_.uncalibrated) + "\""};
}

void BasePoses::Notify(const std::function<bool(ipc::ClientId, const protocol::BasePose&)>& send) {
  for (auto& [id, client] : clients_) {
    if (client.reported) continue;
    protocol::BasePose base_pose;
    base_pose.uncalibrated = static_cast<protocol::Uncalibrated>(file_.uncalibrated);
    base_pose.follows = Follows(client.request) ? 1 : 0;
    if (const int found = FindFor(client.request); found >= 0) {
      const config::AlignmentEntry& entry = file_.entries[static_cast<std::size_t>(found)];
      const Live& live = live_[static_cast<std::size_t>(found)];
      base_pose.known = 1;
      base_pose.doubtful = entry.IsTrusted() ? 0 : 1;
      base_pose.space = entry.space;
      base_pose.base_space = ToWire(PoseOf(entry));
      base_pose.expected_error_m = std::min(1.0, 1e-3 * entry.ErrorNow_mm());
      base_pose.rotation_sigma_rad = entry.rotation_deg / 57.29577951308232;
      base_pose.measured_unix_s = UnixSeconds(entry.date);
      base_pose.changes_until_ns = live.changes_until_ns;
      base_pose.revision = live.revision;
    }
    client.reported = send(id, base_pose);
  }
}

const protocol::BasePoseRequest* BasePoses::RequestOf(ipc::ClientId id) const {
  const auto client = clients_.find(id);
  return client == clients_.end() ? nullptr : &client->second.request;
}

bool BasePoses::IsAligned(ipc::ClientId id) const {
  const auto client = clients_.find(id);
  if (client == clients_.end() || file_.uncalibrated == config::UncalibratedPolicy::kOff) return false;
  if (Follows(client->second.request)) return followed_seen_;
  const int found = FindFor(client->second.request);
  return found >= 0 && file_.entries[static_cast<std::size_t>(found)].IsTrusted();
}

BasePoseWriter::BasePoseWriter(Reply reply) : reply_(std::move(reply)), writer_(config::WriteTextFile) {}

BasePoses::Write BasePoseWriter::write() {
  return [this](const std::string& path, const std::string& text) {
    requested_ = writer_.RequestWrite(path, text);
    return base::Status(base::Ok{});
  };
}

void BasePoseWriter::ReplyWhenWritten(ipc::ClientId id, std::uint32_t number, const BasePoses::Done& done) {
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
