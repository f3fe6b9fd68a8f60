// Where the base stands, from the service: requested once per session, followed from then on.
#include <algorithm>
#include <cstring>

#include "layer/src/spaces/alignment.h"
#include "service/base/clock.h"
#include "service/protocol/text.h"

namespace omni::layer {
namespace {

// For a base that is not aligned: a place within reach, but not a measured one.
BasePose Guess(bool valid, bool tracked) {
  BasePose guess;
  guess.valid = valid;
  guess.tracked = tracked;
  return guess;
}

BasePose ToBasePose(const protocol::BasePose& received) {
  const bool off = received.uncalibrated == protocol::Uncalibrated::kOff;
  const bool front = received.uncalibrated == protocol::Uncalibrated::kFrontOfUser;
  const bool follows = !off && received.follows == 1;
  // The pen is tracked about a base whose place is a guess: engines hide what was never TRACKED (docs/decisions/0020).
  if (off || received.known == 0) {
    BasePose guess = Guess(!off && front, true);
    guess.follows = follows;
    return guess;
  }
  const auto& p = received.base_space.position_m;
  const auto& q = received.base_space.orientation_wxyz;
  BasePose base_pose;
  base_pose.space = static_cast<XrReferenceSpaceType>(received.space);
  base_pose.X_LO = {{p[0], p[1], p[2]}, glm::normalize(glm::dquat(q[0], q[1], q[2], q[3]))};
  base_pose.tracked = received.doubtful == 0;
  base_pose.follows = follows;
  return base_pose;
}

protocol::WirePose ToWire(const XrPosef& pose) {
  const Pose unit = FromXr(pose);
  return {.position_m = {unit.p.x, unit.p.y, unit.p.z}, .orientation_wxyz = {unit.q.w, unit.q.x, unit.q.y, unit.q.z}};
}

}  // namespace

void Alignment::RequestBasePose(Session& session, XrSystemId system) {
  // Until the service answers; a conformance test sets the device's pose itself.
  session.base_pose.Set(Guess(true, link_.test() != nullptr), 0);
  XrInstanceProperties runtime{XR_TYPE_INSTANCE_PROPERTIES, nullptr, 0, {}};
  XrSystemProperties headset{XR_TYPE_SYSTEM_PROPERTIES, nullptr, 0, 0, {}, {}, {}};
  if (XR_FAILED(runtime_.next.GetInstanceProperties(runtime_.handle, &runtime)) ||
      XR_FAILED(runtime_.next.GetSystemProperties(runtime_.handle, system, &headset))) {
    log_.WriteLine("the runtime does not name itself or its headset: the base is assumed in front of the user");
    return;
  }
  protocol::BasePoseRequest request;
  protocol::SetField(request.headset.runtime, std::string_view(runtime.runtimeName, strnlen(runtime.runtimeName, 127)));
  protocol::SetField(request.headset.system, std::string_view(headset.systemName, strnlen(headset.systemName, 255)));
  for (std::size_t i = 0; i < kAnchorTypes.size(); ++i) {
    if (session.anchors[i] != XR_NULL_HANDLE) request.spaces[request.space_count++] = kAnchorTypes[i];
  }
  if (request.space_count > 0) link_.RequestBasePose(request);
}

// Called wherever the socket is polled; almost always there is nothing.
void Alignment::Poll() {
  const std::optional<protocol::BasePose> received = link_.PopBasePose();
  if (!received) return;
  {
    const std::lock_guard lock(mutex_);
    placed_ = received;
  }
  // Changes that the runtime has already made are in the service's file. A pending one is not, unless it says so.
  const std::int64_t known_until_ns =
      std::max(base::MonotonicNow_ns(),
               received->changes_until_ns == 0 ? 0 : received->changes_until_ns + protocol::kSameChange_ns);
  BasePose base_pose = ToBasePose(*received);
  if (link_.test() != nullptr) {
    base_pose.valid = base_pose.tracked = true;
    base_pose.follows = false;
  }
  for (const auto& session : records_.sessions.Values()) session->base_pose.Set(base_pose, clock_.ToXr(known_until_ns));
  if (received->known == 0 && received->follows == 0)
    log_.WriteLine("this headset is not aligned with the base: run `omni align`");
}

void Alignment::OnSpaceChange(XrEventDataReferenceSpaceChangePending change) {
  const auto session = records_.sessions.Find(change.session);
  if (!session) return;
  // Out of range or NaN: the new origin counts as unknown.
  const bool in_range = protocol::PoseProblem(ToWire(change.poseInPreviousSpace)) == nullptr;
  if (!in_range) change.poseValid = XR_FALSE;
  const bool news = ReportChange(change);
  if (!news || session->base_pose.OnChange(change)) return;
  log_.WriteLine(
      "the runtime moves the origin of the base's reference space to an unknown place: the pen's poses are no longer "
      "tracked; run `omni align` again");
}

// Notifies the service, whose file follows. False: another application was faster, and our base pose includes it.
bool Alignment::ReportChange(const XrEventDataReferenceSpaceChangePending& change) {
  protocol::SpaceChange report;
  report.space = change.referenceSpaceType;
  report.pose_valid = change.poseValid ? 1 : 0;
  report.changes_at_ns = clock_.ToMonotonic(change.changeTime);
  if (change.poseValid) report.new_in_previous = ToWire(change.poseInPreviousSpace);
  {
    const std::lock_guard lock(mutex_);
    if (placed_ && placed_->known == 1 && placed_->space == report.space && placed_->changes_until_ns != 0 &&
        report.changes_at_ns <= placed_->changes_until_ns + protocol::kSameChange_ns) {
      return false;
    }
  }
  link_.SendSpaceChange(report);
  return true;
}

}  // namespace omni::layer
