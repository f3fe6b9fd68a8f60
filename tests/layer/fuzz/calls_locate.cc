// The fuzzed calls about many spaces at once and about a tracked hand.
#include <array>
#include <limits>

#include "tests/layer/fuzz/pick.h"
#include "tests/layer/fuzz/sequence.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace {

constexpr std::uint32_t kMostSpaces = 5;

}  // namespace

XrTime Sequence::AnyTime() {
  const std::uint32_t kind = random_.Below(20);
  const std::int64_t now = Now_ns() + kRuntimeOffset_ns;
  const XrTime near = now - 200'000'000 + 1'000'000 * static_cast<std::int64_t>(random_.Below(300));
  static constexpr XrTime kOdd[] = {0, -5, std::numeric_limits<XrTime>::max(), std::numeric_limits<XrTime>::min(), 1};
  return kind < std::size(kOdd) ? kOdd[kind] : near;
}

// [xrLocateSpaces] what each space must be, one by one, and the counts of the answer.
void Sequence::LocateMany() {
  const bool by_core_name = f_.LocateSpaces && random_.Percent(50);
  const PFN_xrLocateSpaces locate = by_core_name ? f_.LocateSpaces : f_.LocateSpacesKHR;
  if (!locate) return Violation("xrLocateSpacesKHR is missing");
  std::array<XrSpace, kMostSpaces> spaces{};
  std::array<XrSpaceLocationData, kMostSpaces> places{};
  std::array<XrSpaceVelocityData, kMostSpaces> speeds{};
  for (XrSpaceLocationData& place : places) place.pose.orientation.w = 1;
  const std::uint32_t count = random_.Below(kMostSpaces + 1);
  const XrSession session = Pick(sessions_);
  for (std::uint32_t i = 0; i < count; ++i) spaces[i] = SpaceFor(session);
  const auto also = [&] { return random_.Percent(4) ? random_.Below(kMostSpaces + 1) : count; };
  const XrSpacesLocateInfo info{
      Type(XR_TYPE_SPACES_LOCATE_INFO), Chain(), SpaceFor(session), AnyTime(), count, OrNull(spaces.data())};
  XrSpaceVelocities velocities{XR_TYPE_SPACE_VELOCITIES, nullptr, also(), OrNull(speeds.data())};
  const bool wants_velocities = random_.Percent(60);
  XrSpaceLocations locations{Type(XR_TYPE_SPACE_LOCATIONS), wants_velocities ? &velocities : nullptr, also(),
                             OrNull(places.data())};
  const XrResult result = locate(session, OrNull(&info), OrNull(&locations));
  std::string text;
  for (std::uint32_t i = 0; XR_SUCCEEDED(result) && i < count; ++i) {
    text += " " + std::to_string(places[i].locationFlags) + "/" + std::to_string(speeds[i].velocityFlags) +
            PoseText(places[i].pose);
    CheckPlace(places[i].locationFlags, places[i].pose);
    if (wants_velocities)
      CheckSpeed(places[i].locationFlags, speeds[i].velocityFlags, speeds[i].linearVelocity, speeds[i].angularVelocity);
  }
  Say("locate many", result, text);
  Expect("locate many", result, {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID});
}

void Sequence::MakeHand() {
  if (hands_.live.size() > 4) return;
  const XrHandTrackerCreateInfoEXT info{Type(XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT), Chain(),
                                        static_cast<XrHandEXT>(1 + random_.Below(3)), XR_HAND_JOINT_SET_DEFAULT_EXT};
  XrHandTrackerEXT tracker = XR_NULL_HANDLE;
  const XrSession session = Pick(sessions_);
  const XrResult result = f_.CreateHandTrackerEXT(session, OrNull(&info), OrNull(&tracker));
  Say("create hand", result);
  if (XR_SUCCEEDED(result)) Keep(hands_, tracker, session);
}

void Sequence::DropHand() { Drop(hands_, f_.DestroyHandTrackerEXT, "destroy hand"); }

void Sequence::Joints() {
  std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> places{};
  std::array<XrHandJointVelocityEXT, XR_HAND_JOINT_COUNT_EXT> speeds{};
  const auto count = [&] { return random_.Percent(4) ? random_.Below(30) : XR_HAND_JOINT_COUNT_EXT; };
  const XrHandTrackerEXT tracker = Pick(hands_);
  const XrHandJointsLocateInfoEXT info{Type(XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT), Chain(), SpaceFor(tracker),
                                       AnyTime()};
  XrHandJointVelocitiesEXT velocities{XR_TYPE_HAND_JOINT_VELOCITIES_EXT, nullptr, count(), OrNull(speeds.data())};
  const bool wants_velocities = random_.Percent(60);
  XrHandJointLocationsEXT locations{Type(XR_TYPE_HAND_JOINT_LOCATIONS_EXT), wants_velocities ? &velocities : nullptr,
                                    XR_FALSE, count(), OrNull(places.data())};
  const XrResult result = f_.LocateHandJointsEXT(tracker, OrNull(&info), OrNull(&locations));
  std::string text;
  if (XR_SUCCEEDED(result)) {
    text = " active " + std::to_string(locations.isActive) + " flags " + std::to_string(places[5].locationFlags);
    for (std::size_t i = 0; i < places.size(); ++i) {
      CheckPlace(places[i].locationFlags, places[i].pose);
      if (!wants_velocities) continue;
      CheckSpeed(places[i].locationFlags, speeds[i].velocityFlags, speeds[i].linearVelocity, speeds[i].angularVelocity);
    }
  }
  Say("joints", result, text);
  Expect("joints", result,
         {XR_ERROR_VALIDATION_FAILURE, XR_ERROR_HANDLE_INVALID, XR_ERROR_TIME_INVALID, XR_ERROR_FEATURE_UNSUPPORTED});
}

}  // namespace omni::test
