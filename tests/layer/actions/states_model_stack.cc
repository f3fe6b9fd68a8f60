// The reference model against everything at once: loader, layer, service and runtime. The runtime's own states below
// the layer are queried directly: handles are the same on both sides.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <sstream>

#include "tests/layer/actions/action_model.h"
#include "tests/layer/support/app.h"
#include "tests/runtime/negotiation.h"

extern "C" XrResult xrNegotiateLoaderRuntimeInterface(const omni::runtime::NegotiateLoaderInfo* loader,
                                                      omni::runtime::NegotiateRuntimeRequest* request);

namespace omni::test {
namespace test_states_model_stack {

using protocol::InputIndex;

constexpr int kScenarios = 60;
constexpr int kSyncsPerScenario = 30;
// Of the layer's measurement of the runtime's clock.
constexpr std::int64_t kClockTolerance_ns = 2'000'000;

PFN_xrGetInstanceProcAddr RuntimeFunctions() {
  omni::runtime::NegotiateLoaderInfo loader{};
  loader.struct_type = omni::runtime::kLoaderInfoType;
  loader.struct_version = omni::runtime::kStructVersion;
  loader.struct_size = sizeof(loader);
  loader.min_interface_version = loader.max_interface_version = 1;
  loader.min_api_version = XR_MAKE_VERSION(1, 0, 0);
  loader.max_api_version = XR_MAKE_VERSION(1, 0x3ff, 0xfff);
  omni::runtime::NegotiateRuntimeRequest request{};
  request.struct_type = omni::runtime::kRuntimeRequestType;
  request.struct_version = omni::runtime::kStructVersion;
  request.struct_size = sizeof(request);
  if (XR_FAILED(xrNegotiateLoaderRuntimeInterface(&loader, &request))) return nullptr;
  return request.get_instance_proc_addr;
}

template <class Function>
Function Below(const App& app, const char* name) {
  static const PFN_xrGetInstanceProcAddr get = RuntimeFunctions();
  PFN_xrVoidFunction found = nullptr;
  if (!get || XR_FAILED(get(app.instance, name, &found))) std::abort();
  return reinterpret_cast<Function>(found);
}

struct Answer {
  bool active = false, changed = false;
  float x = 0, y = 0;
  XrTime t = 0;
};

// By the functions of `app` (above the layer) or of the runtime (below it).
Answer Ask(const App& app, XrActionType type, XrAction action, XrPath subaction, bool below) {
  const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, subaction};
  const auto common = [](const auto& s) {
    return Answer{s.isActive == XR_TRUE, s.changedSinceLastSync == XR_TRUE, 0, 0, s.lastChangeTime};
  };
  if (type == XR_ACTION_TYPE_BOOLEAN_INPUT) {
    XrActionStateBoolean s{XR_TYPE_ACTION_STATE_BOOLEAN};
    const auto get =
        below ? Below<PFN_xrGetActionStateBoolean>(app, "xrGetActionStateBoolean") : xrGetActionStateBoolean;
    EXPECT_EQ(get(app.session, &info, &s), XR_SUCCESS);
    Answer out = common(s);
    out.x = s.currentState ? 1.0f : 0.0f;
    return out;
  }
  if (type == XR_ACTION_TYPE_FLOAT_INPUT) {
    XrActionStateFloat s{XR_TYPE_ACTION_STATE_FLOAT};
    const auto get = below ? Below<PFN_xrGetActionStateFloat>(app, "xrGetActionStateFloat") : xrGetActionStateFloat;
    EXPECT_EQ(get(app.session, &info, &s), XR_SUCCESS);
    Answer out = common(s);
    out.x = s.currentState;
    return out;
  }
  if (type == XR_ACTION_TYPE_VECTOR2F_INPUT) {
    XrActionStateVector2f s{XR_TYPE_ACTION_STATE_VECTOR2F};
    const auto get =
        below ? Below<PFN_xrGetActionStateVector2f>(app, "xrGetActionStateVector2f") : xrGetActionStateVector2f;
    EXPECT_EQ(get(app.session, &info, &s), XR_SUCCESS);
    Answer out = common(s);
    out.x = s.currentState.x;
    out.y = s.currentState.y;
    return out;
  }
  XrActionStatePose s{XR_TYPE_ACTION_STATE_POSE};
  const auto get = below ? Below<PFN_xrGetActionStatePose>(app, "xrGetActionStatePose") : xrGetActionStatePose;
  EXPECT_EQ(get(app.session, &info, &s), XR_SUCCESS);
  Answer out;
  out.active = s.isActive == XR_TRUE;
  return out;
}

const std::vector<layer::Profile>& LayerProfiles() {
  static const std::vector<layer::Profile> all = layer::LoadProfiles();
  return all;
}

const layer::Profile& ProfileAt(const char* path) {
  return *std::find_if(LayerProfiles().begin(), LayerProfiles().end(),
                       [path](const layer::Profile& p) { return p.path == path; });
}

class StackScenario {
 public:
  explicit StackScenario(std::uint64_t seed) : random_(seed), app_(Options()) {
    MakeSets();
    MakeSuggestions();
  }
  // Empty: all agreed.
  std::string Run();
  long active_states = 0, changes = 0;

 private:
  static AppOptions Options() {
    AppOptions options;
    options.attach = false;
    options.mx_ink_extension = true;
    options.extensions = {"XR_KHR_generic_controller", "XR_OMNIX1_stylus_interaction",
                          XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME};
    return options;
  }
  int Below100() { return static_cast<int>(random_() % 100); }
  bool Chance(int percent) { return Below100() < percent; }
  template <class T>
  const T& Of(const std::vector<T>& all) {
    return all[random_() % all.size()];
  }
  XrPath PathAt(At at) const { return at == At::kNull ? XR_NULL_PATH : at == At::kLeft ? app_.left : app_.right; }

  void MakeSets();
  void MakeSuggestions();
  std::string ValidPath(const layer::Profile& profile);
  void Live();
  void MoveInputs();
  XrResult Sync();
  std::string CompareWith(const ActionModel& model);

  std::mt19937_64 random_;
  FakeService service_;
  App app_;
  std::vector<XrActionSet> sets_;
  std::vector<std::uint32_t> priorities_;
  std::vector<XrAction> handles_;
  std::vector<ModelAction> actions_;
  std::vector<ModelSuggestion> suggestions_;
  ModelSync sync_;
  bool focus_ = true;
};

void StackScenario::MakeSets() {
  static int serial = 0;
  for (int i = 0; i < 3; ++i) {
    priorities_.push_back(static_cast<std::uint32_t>(random_() % 3));
    sets_.push_back(app_.MakeSet(("scenario" + std::to_string(serial++)).c_str(), priorities_.back()));
  }
  const std::vector<XrActionType> types{XR_ACTION_TYPE_BOOLEAN_INPUT, XR_ACTION_TYPE_BOOLEAN_INPUT,
                                        XR_ACTION_TYPE_FLOAT_INPUT, XR_ACTION_TYPE_VECTOR2F_INPUT,
                                        XR_ACTION_TYPE_POSE_INPUT};
  for (int i = 0; i < 10; ++i) {
    ModelAction m;
    m.set = static_cast<int>(random_() % 3);
    m.type = Of(types);
    if (Chance(75)) {
      m.left = Chance(60);
      m.right = Chance(80);
    }
    XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
    std::snprintf(info.actionName, sizeof(info.actionName), "action%d", i);
    std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "Action %d", i);
    info.actionType = m.type;
    std::vector<XrPath> hands;
    if (m.left) hands.push_back(app_.left);
    if (m.right) hands.push_back(app_.right);
    info.countSubactionPaths = static_cast<std::uint32_t>(hands.size());
    info.subactionPaths = hands.data();
    XrAction action = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateAction(sets_[static_cast<std::size_t>(m.set)], &info, &action), XR_SUCCESS);
    handles_.push_back(action);
    actions_.push_back(m);
  }
}

std::string StackScenario::ValidPath(const layer::Profile& profile) {
  for (;;) {
    const layer::Hand hand = Chance(30) ? layer::Hand::kLeft : layer::Hand::kRight;
    std::string path = Chance(75) ? Of(profile.components).path : Of(profile.poses).path;
    if (Chance(25)) path = path.substr(0, path.rfind('/'));
    if (layer::HasPath(profile, hand, path, {"XR_OMNIX1_stylus_interaction"}))
      return std::string(layer::UserPath(hand)) + path;
  }
}

void StackScenario::MakeSuggestions() {
  std::vector<const char*> profiles{kTouch, kIndex, kSimple, kGeneric, kMxInk, kOmniStylus};
  std::shuffle(profiles.begin(), profiles.end(), random_);
  profiles.resize(1 + random_() % 3);
  for (const char* profile : profiles) {
    std::vector<std::string> paths;
    std::vector<Bound> bindings;
    paths.reserve(20);
    for (int i = 0; i < 16; ++i) {
      const int action = static_cast<int>(random_() % actions_.size());
      paths.push_back(ValidPath(ProfileAt(profile)));
      bindings.push_back({handles_[static_cast<std::size_t>(action)], paths.back().c_str()});
      suggestions_.push_back({profile, action, paths.back(), std::nullopt});
    }
    EXPECT_EQ(app_.Suggest(profile, bindings), XR_SUCCESS) << profile;
  }
}

void StackScenario::MoveInputs() {
  for (int moves = Below100() % 8; moves > 0; --moves) {
    const auto index = static_cast<InputIndex>(random_() % protocol::kInputCount);
    if (index == InputIndex::kDocked && Chance(70)) continue;
    const bool axis = index == InputIndex::kThumbstickX || index == InputIndex::kThumbstickY;
    const float value = 0.1f * static_cast<float>(axis ? Below100() % 21 - 10 : Below100() % 11);
    protocol::InputValue& input = sync_.inputs.components[static_cast<std::size_t>(index)];
    input.press_count += input.value <= 0.5f && value > 0.5f;
    input.release_count += input.value > 0.5f && value <= 0.5f;
    input.t_change_ns = service_.Set(index, value) + kRuntimeOffset_ns;
    input.value = value;
  }
  const char* const side = Chance(50) ? "left" : "right";
  const std::string user = std::string("/user/hand/") + side;
  omni_test_set_float((user + "/input/trigger/value").c_str(), 0.1f * static_cast<float>(Below100() % 11));
  omni_test_set_vector2((user + "/input/thumbstick").c_str(), 0.3f, -0.1f * static_cast<float>(Below100() % 11));
  omni_test_set_bool((user + (side[0] == 'l' ? "/input/x/click" : "/input/a/click")).c_str(), Chance(50));
}

void StackScenario::Live() {
  MoveInputs();
  if (Chance(10)) omni_test_set_device("right", Chance(50), nullptr);
  if (Chance(8)) omni_test_set_device("left", Chance(70), nullptr);
  if (Chance(8)) sync_.pen_present = !sync_.pen_present;
  service_.SetFlags(sync_.pen_present ? protocol::kToolPoseValid | protocol::kToolTracked : 0u);
  const bool before = focus_;
  focus_ = Chance(focus_ ? 92 : 60);
  if (focus_ != before) omni_test_set_focus(focus_);
  sync_.focused = focus_;
  sync_.start_edges = before && !focus_;
  sync_.active.clear();
  for (int set = 0; set < 3; ++set) {
    if (Chance(75)) sync_.active.push_back({set, At::kNull, priorities_[static_cast<std::size_t>(set)]});
    for (const At hand : {At::kLeft, At::kRight}) {
      const bool declared = std::any_of(actions_.begin(), actions_.end(),
                                        [&](const ModelAction& a) { return a.set == set && a.HasSubaction(hand); });
      if (declared && Chance(15)) sync_.active.push_back({set, hand, priorities_[static_cast<std::size_t>(set)]});
    }
  }
}

XrResult StackScenario::Sync() {
  std::vector<XrActiveActionSet> active;
  for (const ModelActiveSet& entry : sync_.active)
    active.push_back({sets_[static_cast<std::size_t>(entry.set)], PathAt(entry.at)});
  XrActiveActionSetPriorityEXT priority{sets_[random_() % 3], static_cast<std::uint32_t>(random_() % 4)};
  const XrActiveActionSetPrioritiesEXT priorities{XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT, nullptr, 1, &priority};
  const bool overridden = Chance(20);
  for (ModelActiveSet& entry : sync_.active)
    if (overridden && sets_[static_cast<std::size_t>(entry.set)] == priority.actionSet)
      entry.priority = priority.priorityOverride;
  const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, overridden ? static_cast<const void*>(&priorities) : nullptr,
                               static_cast<std::uint32_t>(active.size()), active.data()};
  service_.Fill();
  const XrResult result = xrSyncActions(app_.session, &info);
  sync_.now = Now_ns() + kRuntimeOffset_ns;
  return result;
}

std::string StackScenario::CompareWith(const ActionModel& model) {
  std::ostringstream why;
  const std::string profile = app_.Profile(app_.right);
  if (!model.Profile().empty() && profile != model.Profile())
    why << "profile " << profile << ", should be " << model.Profile() << "; ";
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    for (const At at : {At::kNull, At::kLeft, At::kRight}) {
      if (at != At::kNull && !actions_[i].HasSubaction(at)) continue;
      const Answer is = Ask(app_, actions_[i].type, handles_[i], PathAt(at), false);
      const Answer below = Ask(app_, actions_[i].type, handles_[i], PathAt(at), true);
      const std::optional<ModelState> model_state = model.State(static_cast<int>(i), at);
      const ModelState wanted =
          model_state.value_or(ModelState{below.active, below.changed, below.x, below.y, below.t, below.t});
      active_states += is.active;
      changes += is.changed;
      const bool same = is.active == wanted.active && is.changed == wanted.changed && is.x == wanted.x &&
                        is.y == wanted.y && is.t >= wanted.last_change_earliest - kClockTolerance_ns &&
                        is.t <= wanted.last_change_latest + kClockTolerance_ns;
      if (same) continue;
      why << "action " << i << " type " << actions_[i].type << " at " << static_cast<int>(at)
          << (model_state ? "" : " (the runtime's)") << ": active " << is.active << " changed " << is.changed
          << " value " << is.x << "," << is.y << " t " << is.t << ", should be " << wanted.active << " "
          << wanted.changed << " " << wanted.x << "," << wanted.y << " t " << wanted.last_change_earliest << ".."
          << wanted.last_change_latest;
      return why.str();
    }
  }
  return why.str();
}

std::string StackScenario::Run() {
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 3, sets_.data()};
  EXPECT_EQ(xrAttachSessionActionSets(app_.session, &attach), XR_SUCCESS);
  service_.SetFlags(0);
  // Connected, and base pose requested: until then the pen is not present. No sync so far.
  for (int i = 0; i < 2000 && service_.heard().base_pose_requests.empty(); ++i) {
    service_.Fill();
    app_.Poll();
    const timespec pause{0, 2'000'000};
    nanosleep(&pause, nullptr);
  }
  ActionModel model(LayerProfiles(), actions_, suggestions_, {0, 1, 2});
  const auto profile_below = Below<PFN_xrGetCurrentInteractionProfile>(app_, "xrGetCurrentInteractionProfile");
  const timespec pause{0, 12'000'000};  // the answer reaches the layer at one of its polls of the socket
  nanosleep(&pause, nullptr);
  app_.Poll();
  sync_.service = 1;
  for (int step = 0; step < kSyncsPerScenario; ++step) {
    Live();
    const XrResult result = Sync();
    if (result != (focus_ ? XR_SUCCESS : XR_SESSION_NOT_FOCUSED)) return Name(result);
    XrInteractionProfileState below{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
    EXPECT_EQ(profile_below(app_.session, app_.right, &below), XR_SUCCESS);
    const bool docked = sync_.inputs.components[static_cast<std::size_t>(InputIndex::kDocked)].value > 0.5f;
    sync_.put_down = docked && below.interactionProfile != XR_NULL_PATH;
    sync_.runtime.clear();
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      for (const At at : {At::kNull, At::kLeft, At::kRight}) {
        if (at != At::kNull && !actions_[i].HasSubaction(at)) continue;
        const Answer a = Ask(app_, actions_[i].type, handles_[i], PathAt(at), true);
        sync_.runtime[{static_cast<int>(i), at}] = {a.active, a.x, a.y, a.t};
      }
    }
    model.Sync(sync_);
    const std::string why = CompareWith(model);
    if (!why.empty()) return "sync " + std::to_string(step) + ": " + why;
  }
  return {};
}

TEST(StatesModelStack, RandomApplicationsMatchTheReferenceModel) {
  long active = 0, changed = 0;
  for (std::uint64_t seed = 1; seed <= kScenarios; ++seed) {
    omni_test_reset();
    StackScenario scenario(seed);
    const std::string why = scenario.Run();
    ASSERT_EQ(why, "") << "seed " << seed;
    active += scenario.active_states;
    changed += scenario.changes;
  }
  std::printf("%d scenarios of %d syncs over the whole stack: %ld active states, %ld changes\n", kScenarios,
              kSyncsPerScenario, active, changed);
  EXPECT_GT(active, 500);
  EXPECT_GT(changed, 100);
}

}  // namespace test_states_model_stack
}  // namespace omni::test
