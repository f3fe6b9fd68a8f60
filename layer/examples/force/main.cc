// omni_force: forces on the pen, through XR_OMNIX1_force_feedback (docs/extensions/XR_OMNIX1_force_feedback.md).
//
//   omni_force [--seconds S] [--hand right|left] [--name NAME]
//
// Three effects, a third of the time each: a breeze that the application itself makes, frame by frame; a table, which
// the device renders by itself a thousand times a second; and honey. It waits for the pen, and prints the acting force
// four times a second. Exit status: 0; 1 with a line on stderr; 2 wrong arguments.

#include <openxr/omni_force_feedback.h>
#include <openxr/openxr.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "session/session.h"

namespace {

using example::Options;
using example::Session;

constexpr XrDuration kSecond_ns = 1'000'000'000;

bool Ok(XrResult result, const char* call) {
  if (XR_SUCCEEDED(result)) return true;
  std::fprintf(stderr, "omni_force: %s failed with XrResult %d\n", call, static_cast<int>(result));
  return false;
}

// 1. The extension is enabled like any other; only the layer knows it, so without the layer it is not offered.
XrInstance CreateInstance(const Options& options, const std::vector<const char*>& for_session, std::string* problem) {
  std::vector<const char*> names = for_session;
  names.push_back(XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME);
  return example::CreateInstance(options.name, names, problem);
}

// 2. Its functions come from xrGetInstanceProcAddr.
struct Functions {
  PFN_xrCreateForceFeedbackOMNIX1 create = nullptr;
  PFN_xrDestroyForceFeedbackOMNIX1 destroy = nullptr;
  PFN_xrGetForceFeedbackPropertiesOMNIX1 get_properties = nullptr;
  PFN_xrApplyForceOMNIX1 apply = nullptr;
  PFN_xrSetForceFeedbackConstraintsOMNIX1 set_constraints = nullptr;
  PFN_xrStopForceFeedbackOMNIX1 stop = nullptr;
  PFN_xrGetForceFeedbackStateOMNIX1 get_state = nullptr;
};

template <class Function>
bool Load(XrInstance instance, const char* name, Function& function) {
  PFN_xrVoidFunction found = nullptr;
  if (!Ok(xrGetInstanceProcAddr(instance, name, &found), name)) return false;
  function = reinterpret_cast<Function>(found);
  return true;
}

bool LoadFunctions(XrInstance instance, Functions& xr) {
  return Load(instance, "xrCreateForceFeedbackOMNIX1", xr.create) &&
         Load(instance, "xrDestroyForceFeedbackOMNIX1", xr.destroy) &&
         Load(instance, "xrGetForceFeedbackPropertiesOMNIX1", xr.get_properties) &&
         Load(instance, "xrApplyForceOMNIX1", xr.apply) &&
         Load(instance, "xrSetForceFeedbackConstraintsOMNIX1", xr.set_constraints) &&
         Load(instance, "xrStopForceFeedbackOMNIX1", xr.stop) &&
         Load(instance, "xrGetForceFeedbackStateOMNIX1", xr.get_state);
}

// What an application knows while it runs.
struct Force {
  Functions xr;
  XrSpace local = XR_NULL_HANDLE;  // all that follows is in LOCAL: the layer knows where the base stands in it
  XrForceFeedbackOMNIX1 pen = XR_NULL_HANDLE;
  XrForceFeedbackPropertiesOMNIX1 properties{};
  int part = -1;
  long frames = 0;
  float largest_N = 0;
};

// 3. A handle for the hand that holds the pen. XR_ERROR_FEATURE_UNSUPPORTED says that there is no pen yet: try again.
// The handle outlives the pen's absence; what was set before is gone then, and isActive says so.
bool FindPen(XrInstance instance, XrSession session, const std::string& hand, XrTime time, Force& force) {
  if (force.pen != XR_NULL_HANDLE) return true;
  XrForceFeedbackCreateInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1, nullptr, XR_NULL_PATH};
  if (!Ok(xrStringToPath(instance, ("/user/hand/" + hand).c_str(), &info.topLevelUserPath), "xrStringToPath"))
    return false;
  if (XR_FAILED(force.xr.create(session, &info, &force.pen))) {
    force.pen = XR_NULL_HANDLE;
    return false;
  }
  // Where force can act: a shell around the base, in any space.
  const XrForceFeedbackPropertiesGetInfoOMNIX1 where{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1, nullptr,
                                                     force.local, time};
  force.properties = {};
  force.properties.type = XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1;
  if (!Ok(force.xr.get_properties(force.pen, &where, &force.properties), "xrGetForceFeedbackPropertiesOMNIX1"))
    return false;
  std::printf("force acts from %.0f to %.0f mm around the base\n", 1e3f * force.properties.innerRadius,
              1e3f * force.properties.outerRadius);
  return true;
}

// 4. A force of the application's own, in newtons. It ends by itself after `duration` unless it is renewed: if the
// application hangs, the hand is released. `ramp` makes steps between frames smooth.
void Breeze(const Force& force, double time_s) {
  const auto swell = static_cast<float>(0.2 * std::sin(2 * 3.14159265 * 0.5 * time_s));
  const XrForceApplyInfoOMNIX1 info{
      XR_TYPE_FORCE_APPLY_INFO_OMNIX1, nullptr, force.local, {swell, 0, 0}, kSecond_ns / 20, kSecond_ns / 90};
  force.xr.apply(force.pen, &info);  // XR_SESSION_NOT_FOCUSED is a success code: no force acts then
}

// 5. A constraint: the device evaluates it at its own rate, so that it is crisp and stable whatever the frame rate is.
// Set once; it holds until others are set, or the focus is lost.
void SetTable(const Force& force) {
  const XrForceFeedbackPropertiesOMNIX1& place = force.properties;
  const float height_m = 0.8f * place.innerRadius + 0.2f * place.outerRadius;  // where the pen is strong
  XrForceFeedbackConstraintPlaneOMNIX1 table{};
  table.type = XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1;
  table.baseSpace = force.local;
  table.stiffness = 300;  // N/m; as much as is stable where the pen is
  table.damping = 0.5f;   // N s/m
  table.maxForce = 1;     // N
  table.position = place.workspacePose.position;
  table.position.y += height_m;
  table.normal = {0, 1, 0};
  table.side = XR_FORCE_FEEDBACK_SIDE_OUTSIDE_OMNIX1;
  const auto* const all = reinterpret_cast<const XrForceFeedbackConstraintBaseHeaderOMNIX1*>(&table);
  const XrForceFeedbackConstraintsSetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr, 1,
                                                     &all};
  Ok(force.xr.set_constraints(force.pen, &info), "xrSetForceFeedbackConstraintsOMNIX1");
}

void SetHoney(const Force& force) {
  XrForceFeedbackConstraintViscousOMNIX1 honey{};
  honey.type = XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_VISCOUS_OMNIX1;
  honey.baseSpace = force.local;
  honey.damping = 2;   // N s/m
  honey.maxForce = 1;  // N
  const auto* const all = reinterpret_cast<const XrForceFeedbackConstraintBaseHeaderOMNIX1*>(&honey);
  const XrForceFeedbackConstraintsSetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr, 1,
                                                     &all};
  Ok(force.xr.set_constraints(force.pen, &info), "xrSetForceFeedbackConstraintsOMNIX1");
}

// 6. The acting force, and why it may be less than requested.
void PrintState(Force& force, XrTime time) {
  const XrForceFeedbackStateGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, force.local,
                                               time};
  XrForceFeedbackStateOMNIX1 state{};
  state.type = XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1;
  if (XR_FAILED(force.xr.get_state(force.pen, &info, &state))) return;
  const XrVector3f& f = state.appliedForce;
  force.largest_N = std::fmax(force.largest_N, std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z));
  if (force.frames % 22 != 0) return;
  std::printf("%s, force (%.2f, %.2f, %.2f) N%s%s%s\n", state.isActive ? "active" : "not active", f.x, f.y, f.z,
              state.stateFlags & XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1 ? ", at the device's limit" : "",
              state.stateFlags & XR_FORCE_FEEDBACK_STATE_OUT_OF_WORKSPACE_BIT_OMNIX1 ? ", too far away" : "",
              state.stateFlags & XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1 ? ", the device has gone" : "");
}

void Frame(Force& force, double time_s, const Options& options, XrTime time) {
  constexpr const char* kNames[] = {"a breeze from the side", "a table below the tip", "honey"};
  ++force.frames;
  const int part = time_s < options.seconds / 3 ? 0 : time_s < 2 * options.seconds / 3 ? 1 : 2;
  if (part != force.part) {
    force.part = part;
    std::printf("now: %s\n", kNames[part]);
    force.xr.stop(force.pen);
    if (part == 1) SetTable(force);
    if (part == 2) SetHoney(force);
  }
  if (part == 0) Breeze(force, time_s);
  PrintState(force, time);
}

void Loop(XrInstance instance, Session& session, const Options& options, Force& force) {
  XrTime start = 0;
  XrTime opened = 0;
  bool leaving = false;
  while (!session.over()) {
    session.PollEvents(nullptr, nullptr);
    const XrTime time = session.NextFrame();
    if (time == 0 || leaving) continue;
    if (opened == 0) opened = time;
    const bool there = session.focused() && FindPen(instance, session.handle(), options.hand, time, force);
    if (there && start == 0) start = time;
    const double time_s = start == 0 ? 0 : 1e-9 * static_cast<double>(time - start);
    const double waited_s = start == 0 ? 1e-9 * static_cast<double>(time - opened) : 0;
    if (time_s >= options.seconds || waited_s >= 2 * options.seconds) {
      leaving = Ok(xrRequestExitSession(session.handle()), "xrRequestExitSession");
      if (!leaving) break;
    } else if (there) {
      Frame(force, time_s, options, time);
    }
  }
  std::printf("frames %ld, largest force %.2f N\n", force.frames, force.largest_N);
}

int Fail(const std::string& problem) {
  if (!problem.empty()) std::fprintf(stderr, "omni_force: %s\n", problem.c_str());
  return 1;
}

int Run(const Options& options) {
  const std::vector<std::string> offered = example::AvailableExtensions();
  std::string problem;
  const std::vector<const char*> for_session = Session::Extensions(offered, &problem);
  if (for_session.empty()) return Fail(problem);
  if (!example::Contains(offered, XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME))
    return Fail("no layer offers XR_OMNIX1_force_feedback: is XR_APILAYER_OMNI_stylus enabled? (omni doctor)");
  const example::Instance instance{CreateInstance(options, for_session, &problem)};
  Force force;
  if (instance.handle == XR_NULL_HANDLE) return Fail(problem);
  if (!LoadFunctions(instance.handle, force.xr)) return 1;
  Session session(instance.handle, for_session);
  if (session.handle() == XR_NULL_HANDLE) return Fail(session.problem());
  const XrReferenceSpaceCreateInfo local{
      XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
  if (!Ok(xrCreateReferenceSpace(session.handle(), &local, &force.local), "xrCreateReferenceSpace")) return 1;
  Loop(instance.handle, session, options, force);
  return force.frames > 0 ? 0 : Fail("no pen was found in that hand: does omnid run? (omni doctor)");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  options.name = "omni_force";
  options.seconds = 9;  // three parts
  if (const auto ended = example::ParseArguments(argc, argv, options)) return *ended;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  return Run(options);
}
