// omni_align_probe: prints where the runtime's controllers are, one line per pose, until standard input ends.
// `omni align` starts it and reads its output; it is an ordinary OpenXR application and knows nothing of Omni.
//
//   runtime NAME                  as it names itself
//   system NAME                   of the headset
//   space N                       XrReferenceSpaceType of all poses below: STAGE, else LOCAL_FLOOR, else LOCAL
//   pose T PART X Y Z QX QY QZ QW CLOCK_MONOTONIC ns; left, right, left_finger, right_finger; metres
//   motion T X Y Z QX QY QZ QW [VX VY VZ WX WY WZ]   --follow PATH: of that path; m/s, rad/s, if the runtime knows them
//   lost                          --follow PATH: it is not tracked now
//   moved                         the runtime moves that space: earlier poses have another origin
//   end REASON                    the session is over

#include <openxr/openxr.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

#define XR_USE_TIMESPEC
#include <openxr/openxr_platform.h>

#include <algorithm>
#include <cinttypes>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "align/hands.h"
#include "session/session.h"

namespace {

// XR_REFERENCE_SPACE_TYPE_LOCAL_FLOOR of OpenXR 1.1, which older headers lack.
constexpr auto kLocalFloor = static_cast<XrReferenceSpaceType>(1000426000);
constexpr XrReferenceSpaceType kPreferred[] = {XR_REFERENCE_SPACE_TYPE_STAGE, kLocalFloor,
                                               XR_REFERENCE_SPACE_TYPE_LOCAL};

struct Runtime {
  XrInstance instance = XR_NULL_HANDLE;
  std::vector<const char*> session_extensions;
  bool fingers = false;
  std::string follow;  // a path; empty: both hands
  PFN_xrConvertTimeToTimespecTimeKHR to_timespec = nullptr;
  PFN_xrConvertTimespecTimeToTimeKHR to_time = nullptr;
};

int Fail(const std::string& problem) {
  std::printf("end %s\n", problem.c_str());
  return 1;
}

// On one line, whatever the runtime's name contains.
std::string OneLine(const char* name, std::size_t capacity) {
  std::string text(name, strnlen(name, capacity));
  std::replace_if(
      text.begin(), text.end(), [](char c) { return static_cast<unsigned char>(c) < 0x20; }, ' ');
  return text;
}

std::string MakeInstance(Runtime* runtime) {
  const bool fingers = runtime->fingers;
  const std::vector<std::string> offered = example::AvailableExtensions();
  std::string problem;
  runtime->session_extensions = example::Session::Extensions(offered, &problem);
  if (!problem.empty()) return problem;
  std::vector<const char*> enabled = runtime->session_extensions;
  const auto add = [&](const char* name) {
    const bool there = std::any_of(enabled.begin(), enabled.end(), [name](const char* e) { return !strcmp(e, name); });
    if (!there && example::Contains(offered, name)) enabled.push_back(name);
    return there || example::Contains(offered, name);
  };
  const bool timespec = add(XR_KHR_CONVERT_TIMESPEC_TIME_EXTENSION_NAME);
  if (fingers && !add(XR_EXT_HAND_TRACKING_EXTENSION_NAME)) {
    return "the runtime offers no XR_EXT_hand_tracking; use another method";
  }
  if (align::Follower::IsTracker(runtime->follow) && !add(align::kTrackerExtension)) {
    return std::string("the runtime offers no ") + align::kTrackerExtension + "; follow a controller";
  }
  runtime->instance = example::CreateInstance("Omni align", enabled, &problem);
  if (runtime->instance == XR_NULL_HANDLE) return problem;
  PFN_xrVoidFunction found = nullptr;
  if (timespec && XR_SUCCEEDED(xrGetInstanceProcAddr(runtime->instance, "xrConvertTimeToTimespecTimeKHR", &found))) {
    runtime->to_timespec = reinterpret_cast<PFN_xrConvertTimeToTimespecTimeKHR>(found);
  }
  if (timespec && XR_SUCCEEDED(xrGetInstanceProcAddr(runtime->instance, "xrConvertTimespecTimeToTimeKHR", &found))) {
    runtime->to_time = reinterpret_cast<PFN_xrConvertTimespecTimeToTimeKHR>(found);
  }
  return {};
}

// The space whose origin users move least often.
XrReferenceSpaceType Choose(XrSession session) {
  uint32_t count = 0;
  xrEnumerateReferenceSpaces(session, 0, &count, nullptr);
  std::vector<XrReferenceSpaceType> offered(count);
  if (XR_FAILED(xrEnumerateReferenceSpaces(session, count, &count, offered.data()))) offered.clear();
  for (const XrReferenceSpaceType type : kPreferred) {
    if (std::find(offered.begin(), offered.end(), type) != offered.end()) return type;
  }
  return XR_REFERENCE_SPACE_TYPE_LOCAL;
}

std::string SayWhoTheyAre(const Runtime& runtime) {
  XrInstanceProperties instance{XR_TYPE_INSTANCE_PROPERTIES, nullptr, 0, {}};
  XrSystemGetInfo wanted{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  XrSystemId id = XR_NULL_SYSTEM_ID;
  XrSystemProperties system{XR_TYPE_SYSTEM_PROPERTIES, nullptr, 0, 0, {}, {}, {}};
  if (XR_FAILED(xrGetInstanceProperties(runtime.instance, &instance)) ||
      XR_FAILED(xrGetSystem(runtime.instance, &wanted, &id)) ||
      XR_FAILED(xrGetSystemProperties(runtime.instance, id, &system))) {
    return "the runtime does not name itself and its headset";
  }
  std::printf("runtime %s\n", OneLine(instance.runtimeName, sizeof(instance.runtimeName)).c_str());
  std::printf("system %s\n", OneLine(system.systemName, sizeof(system.systemName)).c_str());
  return {};
}

// The time of poses on CLOCK_MONOTONIC. Without the extension it is taken as now: the sweep finds the difference.
int64_t ToMonotonic_ns(const Runtime& runtime, XrTime time) {
  timespec at{};
  if (runtime.to_timespec == nullptr || XR_FAILED(runtime.to_timespec(runtime.instance, time, &at))) {
    clock_gettime(CLOCK_MONOTONIC, &at);
  }
  return int64_t{at.tv_sec} * 1'000'000'000 + at.tv_nsec;
}

// Now, where the runtime says what that is; else the time of the frame.
XrTime NowOf(const Runtime& runtime, XrTime frame) {
  timespec now{};
  XrTime time = 0;
  clock_gettime(CLOCK_MONOTONIC, &now);
  const bool known = runtime.to_time != nullptr && XR_SUCCEEDED(runtime.to_time(runtime.instance, &now, &time));
  return frame > 0 && known ? time : frame;
}

// Whoever started us has closed our standard input, or is gone.
bool InputEnded() {
  pollfd in{STDIN_FILENO, POLLIN, 0};
  if (poll(&in, 1, 0) <= 0) return false;
  char byte = 0;
  return (in.revents & (POLLIN | POLLHUP | POLLERR | POLLNVAL)) != 0 && read(STDIN_FILENO, &byte, 1) <= 0;
}

struct Watch {
  XrReferenceSpaceType space;
  XrSession session;
};

void OnEvent(const XrEventDataBuffer& event, void* user) {
  if (event.type != XR_TYPE_EVENT_DATA_REFERENCE_SPACE_CHANGE_PENDING) return;
  const auto& change = reinterpret_cast<const XrEventDataReferenceSpaceChangePending&>(event);
  if (change.referenceSpaceType == static_cast<const Watch*>(user)->space) std::printf("moved\n");
}

void PrintMotion(int64_t t_ns, const align::FollowedMotion& motion) {
  const XrVector3f& p = motion.pose.position;
  const XrQuaternionf& q = motion.pose.orientation;
  std::printf("motion %" PRId64 " %.7g %.7g %.7g %.7g %.7g %.7g %.7g", t_ns, double{p.x}, double{p.y}, double{p.z},
              double{q.x}, double{q.y}, double{q.z}, double{q.w});
  const XrVector3f& v = motion.velocity;
  const XrVector3f& w = motion.turn_rate;
  if (motion.moves) {
    std::printf(" %.7g %.7g %.7g %.7g %.7g %.7g", double{v.x}, double{v.y}, double{v.z}, double{w.x}, double{w.y},
                double{w.z});
  }
  std::printf("\n");
}

// As Run, for one path.
int Follow(const Runtime& runtime, example::Session& session, Watch watch) {
  std::string problem;
  align::Follower follower(runtime.instance, session.handle(), watch.space, runtime.follow, &problem);
  if (!problem.empty()) return Fail(problem);
  while (!session.over() && !InputEnded()) {
    session.PollEvents(OnEvent, &watch);
    const XrTime time = NowOf(runtime, session.NextFrame());
    align::FollowedMotion motion;
    if (follower.Poll(time, &motion)) {
      PrintMotion(ToMonotonic_ns(runtime, time), motion);
    } else {
      std::printf("lost\n");
    }
    std::fflush(stdout);
  }
  return session.over() ? Fail("the runtime has ended the session") : 0;
}

int Run(const Runtime& runtime) {
  if (const std::string problem = SayWhoTheyAre(runtime); !problem.empty()) return Fail(problem);
  example::Session session(runtime.instance, runtime.session_extensions);
  if (session.handle() == XR_NULL_HANDLE) return Fail(session.problem());
  Watch watch{Choose(session.handle()), session.handle()};
  std::printf("space %d\n", static_cast<int>(watch.space));
  if (!runtime.follow.empty()) return Follow(runtime, session, watch);
  std::string problem;
  align::Hands hands(runtime.instance, session.handle(), watch.space, runtime.fingers, &problem);
  if (!problem.empty()) return Fail(problem);
  while (!session.over() && !InputEnded()) {
    session.PollEvents(OnEvent, &watch);
    const XrTime time = session.NextFrame();
    const int64_t t_ns = ToMonotonic_ns(runtime, time);
    for (const align::Seen& seen : hands.Poll(time)) {
      const XrVector3f& p = seen.pose.position;
      const XrQuaternionf& q = seen.pose.orientation;
      std::printf("pose %" PRId64 " %s %.7g %.7g %.7g %.7g %.7g %.7g %.7g\n", t_ns,
                  align::kPartNames[static_cast<std::size_t>(seen.part)], double{p.x}, double{p.y}, double{p.z},
                  double{q.x}, double{q.y}, double{q.z}, double{q.w});
    }
    std::fflush(stdout);
  }
  return session.over() ? Fail("the runtime has ended the session") : 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 1 << 16);
  Runtime runtime;
  runtime.fingers = argc == 2 && std::strcmp(argv[1], "--fingers") == 0;
  if (argc == 3 && std::strcmp(argv[1], "--follow") == 0) runtime.follow = argv[2];
  const bool help = argc == 2 && std::strcmp(argv[1], "--help") == 0;
  if (argc > 1 && !runtime.fingers && runtime.follow.empty()) {
    std::fprintf(help ? stdout : stderr,
                 "usage: omni_align_probe [--fingers | --follow PATH]; `omni align` and `omni follow` start it\n");
    return help ? 0 : 2;
  }
  if (const std::string problem = MakeInstance(&runtime); !problem.empty()) return Fail(problem);
  const int status = Run(runtime);
  xrDestroyInstance(runtime.instance);
  return status;
}
