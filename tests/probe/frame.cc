// Running: events, then per frame one xrSyncActions, the states, the pose.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

#include "tests/probe/app.h"

namespace probe {
namespace {

constexpr int64_t kSecond_ns = 1'000'000'000;
constexpr XrDuration kPulse_ns = 30'000'000;
// An exit that was asked for must come within this time.
constexpr double kExitPatience_s = 2;

int64_t Monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return int64_t{now.tv_sec} * kSecond_ns + now.tv_nsec;
}

void SleepUntil(int64_t time_ns) {
  const timespec until{time_ns / kSecond_ns, time_ns % kSecond_ns};
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
}

}  // namespace

// The runtime's clock need not be CLOCK_MONOTONIC: it is asked.
XrTime App::Now() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  XrTime time = 0;
  Check(to_time_(instance_, &now, &time), "xrConvertTimespecTimeToTimeKHR");
  return time;
}

void App::Run(const std::atomic<bool>& stop) {
  const int64_t start_ns = Monotonic_ns();
  const auto period_ns = static_cast<int64_t>(1e9 / options_.rate_Hz);
  int64_t next_ns = start_ns;
  while (!done_) {
    const double time_s = static_cast<double>(Monotonic_ns() - start_ns) * 1e-9;
    const bool over = stop || time_s >= options_.seconds;
    PollEvents();
    if (done_) break;
    if (over && !exit_requested_) {
      if (!running_) break;
      exit_requested_ = true;
      Check(xrRequestExitSession(session_), "xrRequestExitSession");
    }
    if (exit_requested_ && time_s > options_.seconds + kExitPatience_s) break;
    if (running_ && !exit_requested_) Frame(time_s);
    // After a long pause go on from now instead of catching up.
    next_ns = std::max(next_ns + period_ns, Monotonic_ns() - period_ns);
    SleepUntil(next_ns);
  }
}

void App::PollEvents() {
  while (!done_) {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
    const XrResult result = xrPollEvent(instance_, &event);
    if (!Check(result, "xrPollEvent") || result == XR_EVENT_UNAVAILABLE) return;
    if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
      OnStateChanged(reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state);
    } else if (event.type == XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED) {
      ReadProfile();
    } else if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
      done_ = true;
    }
  }
}

void App::OnStateChanged(XrSessionState state) {
  switch (state) {
    case XR_SESSION_STATE_READY: {
      XrSessionBeginInfo info{XR_TYPE_SESSION_BEGIN_INFO};
      info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
      running_ = Check(xrBeginSession(session_, &info), "xrBeginSession");
      break;
    }
    case XR_SESSION_STATE_STOPPING:
      Check(xrEndSession(session_), "xrEndSession");
      running_ = false;
      break;
    case XR_SESSION_STATE_EXITING:
    case XR_SESSION_STATE_LOSS_PENDING:
      done_ = true;
      break;
    default:
      break;
  }
}

void App::ReadProfile() {
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE};
  const XrResult result = xrGetCurrentInteractionProfile(session_, hand_, &state);
  if (!Check(result, "xrGetCurrentInteractionProfile") || state.interactionProfile == profile_) return;
  profile_ = state.interactionProfile;
  std::string text = "none";
  if (profile_ != XR_NULL_PATH) {
    char buffer[XR_MAX_PATH_LENGTH];
    uint32_t length = 0;
    if (!Check(xrPathToString(instance_, profile_, sizeof(buffer), &length, buffer), "xrPathToString")) return;
    text = buffer;
    report_.AddProfile(text);
  }
  if (!options_.quiet) std::printf("profile of the %s hand: %s\n", options_.hand.c_str(), text.c_str());
}

void App::Frame(double time_s) {
  ++report_.frames;
  const XrActiveActionSet active{actions_.set, XR_NULL_PATH};
  XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO};
  info.countActiveActionSets = 1;
  info.activeActionSets = &active;
  // XR_SESSION_NOT_FOCUSED is a success: somebody else has the input, and every state below reads inactive.
  if (!Check(xrSyncActions(session_, &info), "xrSyncActions")) return;
  ReadPose(time_s);
  ReadButtons();
}

template <class State, class Function>
State App::Get(XrAction action, XrStructureType type, Function function, const char* call) {
  XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO};
  info.action = action;
  info.subactionPath = hand_;
  State state{type};
  if (!Check(function(session_, &info, &state), call)) return State{type};
  return state;
}

// A stylus has a tip; a controller is pointed with its aim pose; the grip is always there.
void App::ReadPose(double time_s) {
  const auto is_active = [this](XrAction action) {
    return Get<XrActionStatePose>(action, XR_TYPE_ACTION_STATE_POSE, xrGetActionStatePose, "xrGetActionStatePose")
               .isActive == XR_TRUE;
  };
  const bool tip = is_active(actions_.tip);
  const bool aim = is_active(actions_.aim);
  const bool grip = is_active(actions_.grip);
  const XrSpace space = tip ? tip_ : aim || !grip ? aim_ : grip_;
  if (tip || aim || grip) ++report_.pose_active_frames;

  XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY};
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity, 0, {{0, 0, 0, 1}, {0, 0, 0}}};
  const XrTime now = Now();
  const int64_t before_ns = Monotonic_ns();
  const XrResult result = xrLocateSpace(space, local_, now, &location);
  const int64_t elapsed_ns = Monotonic_ns() - before_ns;
  if (!Check(result, "xrLocateSpace")) return;
  report_.AddLocation(time_s, elapsed_ns, location, velocity);
  const auto frames_per_line = static_cast<long>(std::max(1.0, options_.rate_Hz / 4));
  if (!options_.quiet && report_.frames % frames_per_line == 0) {
    PrintPose(tip ? "tip" : aim ? "aim" : grip ? "grip" : "no pose", location, velocity);
  }
}

void App::ReadButtons() {
  const auto select = Get<XrActionStateBoolean>(actions_.select, XR_TYPE_ACTION_STATE_BOOLEAN, xrGetActionStateBoolean,
                                                "xrGetActionStateBoolean");
  const bool pressed = select.isActive == XR_TRUE && select.currentState == XR_TRUE;
  if (pressed && !select_) {
    ++report_.select_edges;
    if (options_.haptics) Pulse();
  }
  if (pressed != select_ && !options_.quiet) std::printf("select %s\n", pressed ? "pressed" : "released");
  select_ = pressed;
  const auto force = Get<XrActionStateFloat>(actions_.force, XR_TYPE_ACTION_STATE_FLOAT, xrGetActionStateFloat,
                                             "xrGetActionStateFloat");
  report_.force_max = std::max(report_.force_max, double{force.currentState});
  const auto stick = Get<XrActionStateVector2f>(actions_.thumbstick, XR_TYPE_ACTION_STATE_VECTOR2F,
                                                xrGetActionStateVector2f, "xrGetActionStateVector2f");
  const double length = std::hypot(double{stick.currentState.x}, double{stick.currentState.y});
  report_.thumbstick_max = std::max(report_.thumbstick_max, length);
}

void App::Pulse() {
  XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO};
  info.action = actions_.haptic;
  info.subactionPath = hand_;
  XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION};
  vibration.duration = kPulse_ns;
  vibration.frequency = XR_FREQUENCY_UNSPECIFIED;
  vibration.amplitude = 0.5f;
  const auto* const header = reinterpret_cast<const XrHapticBaseHeader*>(&vibration);
  const XrResult result = xrApplyHapticFeedback(session_, &info, header);
  if (Check(result, "xrApplyHapticFeedback") && result != XR_SESSION_NOT_FOCUSED) ++report_.haptics_sent;
}

void App::PrintPose(const char* name, const XrSpaceLocation& location, const XrSpaceVelocity& velocity) {
  const XrVector3f& p = location.pose.position;
  const XrVector3f& v = velocity.linearVelocity;
  const bool valid = (location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0;
  const bool tracked = (location.locationFlags & XR_SPACE_LOCATION_POSITION_TRACKED_BIT) != 0;
  std::printf("%s %+.4f %+.4f %+.4f m  %+.3f %+.3f %+.3f m/s  %s%s\n", name, double{p.x}, double{p.y}, double{p.z},
              double{v.x}, double{v.y}, double{v.z}, valid ? "valid" : "not valid", tracked ? ", tracked" : "");
}

bool App::Check(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  const std::string name = Name(result);
  if (report_.errors.empty()) std::fprintf(stderr, "omni_probe: %s: %s\n", call, name.c_str());
  report_.AddError(call, name);
  if (result == XR_ERROR_INSTANCE_LOST || result == XR_ERROR_SESSION_LOST) done_ = true;
  return false;
}

std::string App::Name(XrResult result) const {
  char name[XR_MAX_RESULT_STRING_SIZE] = "";
  if (instance_ != XR_NULL_HANDLE && XR_SUCCEEDED(xrResultToString(instance_, result, name))) return name;
  return "XrResult " + std::to_string(static_cast<int>(result));
}

}  // namespace probe
