#include "tests/layer/fuzz/sequence.h"

#include <cstdio>
#include <cstring>
#include <stdexcept>

#include "tests/layer/app.h"
#include "tests/layer/fuzz/pick.h"
#include "tests/layer/mini_loader/chain_app.h"

namespace omni::test {
namespace {

const std::vector<std::string> kPaths = {
    "/user/hand/left",
    "/user/hand/right",
    "/user/gamepad",
    "/user/head",
    "/user/hand",
    "/interaction_profiles/oculus/touch_controller",
    "/interaction_profiles/khr/simple_controller",
    "/interaction_profiles/logitech/mx_ink_stylus_logitech",
    "/interaction_profiles/nobody/nothing",
    "/user/hand/left/input/trigger/value",
    "/user/hand/right/input/trigger/value",
    "/user/hand/right/input/trigger",
    "/user/hand/left/input/thumbstick",
    "/user/hand/right/input/thumbstick",
    "/user/hand/right/input/a/click",
    "/user/hand/left/input/x/click",
    "/user/hand/right/input/x/click",
    "/user/hand/left/input/grip/pose",
    "/user/hand/right/input/aim/pose",
    "/user/hand/right/input/grip",
    "/user/hand/left/output/haptic",
    "/user/hand/right/output/haptic",
    "/user/hand/right/input/select/click",
};

constexpr XrStructureType kUnknownType = static_cast<XrStructureType>(1999999999);

}  // namespace

Sequence::Sequence(const MiniLoader& loader, const SequenceOptions& options)
    : options_(options), random_(options.seed) {
  if (XR_FAILED(loader.CreateInstance(InstanceInfo({}), &instance_))) throw std::runtime_error("xrCreateInstance");
  f_ = loader.Load(instance_);
  const XrSystemGetInfo info{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
  f_.GetSystem(instance_, &info, &system_);
  for (const std::string& text : kPaths) paths_.push_back(Interned(text));
  unknown_.type = kUnknownType;
  if (random_.Percent(85)) Prepare();
  for (int i = 0; i < options_.steps; ++i) {
    if (options_.world) options_.world(random_);
    Step();
  }
}

Sequence::~Sequence() { f_.DestroyInstance(instance_); }

// An application in its best state, so that what follows means something.
void Sequence::Prepare() {
  MakeSet();
  for (const XrActionType type : {XR_ACTION_TYPE_POSE_INPUT, XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT,
                                  XR_ACTION_TYPE_VECTOR2F_INPUT, XR_ACTION_TYPE_VIBRATION_OUTPUT})
    MakeAction(type);
  if (random_.Percent(30)) {
    MakeSet();
    MakeAction(XR_ACTION_TYPE_BOOLEAN_INPUT);
  }
  MakeSession();
  Suggest(true);
  Attach(true);
  for (int i = 0; i < 12; ++i) Poll();
  if (sessions_.live.empty() || !options_.arrive) return;
  const XrSession session = sessions_.live.front();
  options_.arrive([&] {
    SyncOnce(true);
    XrInteractionProfileState profile{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
    f_.GetCurrentInteractionProfile(session, Interned("/user/hand/right"), &profile);
    return Text(profile.interactionProfile);
  });
}

void Sequence::Step() {
  struct Weighted {
    int weight;
    void (*call)(Sequence&);
  };
  static constexpr XrActionType kTypes[] = {XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_FLOAT_INPUT,
                                            XR_ACTION_TYPE_VECTOR2F_INPUT, XR_ACTION_TYPE_POSE_INPUT,
                                            XR_ACTION_TYPE_VIBRATION_OUTPUT};
  static constexpr Weighted kCalls[] = {
      {2, [](Sequence& s) { s.Paths(); }},
      {2, [](Sequence& s) { s.MakeSet(); }},
      {3, [](Sequence& s) { s.MakeAction(kTypes[s.random_.Below(5)]); }},
      {1, [](Sequence& s) { s.DropSet(); }},
      {1, [](Sequence& s) { s.DropAction(); }},
      {4, [](Sequence& s) { s.Suggest(false); }},
      {2, [](Sequence& s) { s.Attach(false); }},
      {14, [](Sequence& s) { s.SyncOnce(s.random_.Percent(60)); }},
      {6, [](Sequence& s) { s.Bool(); }},
      {6, [](Sequence& s) { s.Float(); }},
      {4, [](Sequence& s) { s.Vector(); }},
      {4, [](Sequence& s) { s.PoseState(); }},
      {5, [](Sequence& s) { s.Profile(); }},
      {3, [](Sequence& s) { s.Sources(); }},
      {3, [](Sequence& s) { s.SourceName(); }},
      {1, [](Sequence& s) { s.MakeSession(); }},
      {1, [](Sequence& s) { s.DropSession(); }},
      {1, [](Sequence& s) { s.Begin(); }},
      {1, [](Sequence& s) { s.End(); }},
      {1, [](Sequence& s) { s.Exit(); }},
      {8, [](Sequence& s) { s.Poll(); }},
      {1, [](Sequence& s) { s.Frame(); }},
      {2, [](Sequence& s) { s.Views(); }},
      {6, [](Sequence& s) { s.ActionSpace(); }},
      {3, [](Sequence& s) { s.ReferenceSpace(); }},
      {1, [](Sequence& s) { s.DropSpace(); }},
      {14, [](Sequence& s) { s.Locate(); }},
      {4, [](Sequence& s) { s.Vibrate(); }},
      {2, [](Sequence& s) { s.Stop(); }},
  };
  int total = 0;
  for (const Weighted& w : kCalls) total += w.weight;
  int at = static_cast<int>(random_.Below(static_cast<std::uint32_t>(total)));
  for (const Weighted& w : kCalls) {
    at -= w.weight;
    if (at < 0) return w.call(*this);
  }
}

void Sequence::Say(const char* call, XrResult result, const std::string& rest) {
  lines_.push_back(std::string(call) + " -> " + std::to_string(static_cast<int>(result)) + rest);
  // What an exception that an entry point stopped becomes; nothing below gives it.
  if (result == XR_ERROR_RUNTIME_FAILURE || result == XR_ERROR_OUT_OF_MEMORY)
    Violation(std::string(call) + " failed within: " + Name(result));
}

void Sequence::Violation(const std::string& text) {
  violations_.push_back("seed " + std::to_string(options_.seed) + ", call " + std::to_string(lines_.size()) + ": " +
                        text);
}

XrStructureType Sequence::Type(XrStructureType right) { return random_.Percent(3) ? kUnknownType : right; }

// Structures that nobody knows are to be skipped.
const void* Sequence::Chain() { return random_.Percent(5) ? &unknown_ : nullptr; }

XrPath Sequence::AnyPath() {
  const std::uint32_t kind = random_.Below(20);
  if (kind == 0) return XR_NULL_PATH;
  if (kind == 1) return XrPath{987654321};
  return random_.Of(paths_);
}

XrPath Sequence::HandPath() {
  const std::uint32_t kind = random_.Below(10);
  if (kind < 4) return paths_[1];
  if (kind < 6) return paths_[0];
  return kind < 8 ? XrPath{XR_NULL_PATH} : AnyPath();
}

XrPath Sequence::Interned(const std::string& text) {
  XrPath path = XR_NULL_PATH;
  f_.StringToPath(instance_, text.c_str(), &path);
  return path;
}

std::string Sequence::Text(XrPath path) {
  char text[XR_MAX_PATH_LENGTH] = {};
  std::uint32_t length = 0;
  if (path == XR_NULL_PATH) return {};
  if (XR_FAILED(f_.PathToString(instance_, path, sizeof(text), &length, text))) Violation("a path that is none");
  return text;
}

}  // namespace omni::test
