// How engines call OpenXR, over every order in which the pen and the runtime's controllers come and go. The patterns
// are rows; what a hand has to show follows from who is there.
#include <gtest/gtest.h>

#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_engines {

constexpr int kLeftHand = 0, kRightHand = 1;
constexpr const char* kSides[] = {"left", "right"};

std::string UserPath(int hand) { return std::string("/user/hand/") + kSides[hand]; }

// How an application makes the actions of its hands: pose, press and vibration alike.
enum class Declared { kNoPath, kItsHand, kBothHands };
struct Pattern {
  const char* name;
  bool action_per_hand;  // else one for both hands
  Declared declared;
  bool at_null;       // spaces, states and vibrations at XR_NULL_PATH, else at the hand's subaction path
  bool spaces_first;  // before the suggestions and the attachment
  bool set_per_hand;  // an action set per hand, both in every sync
  std::vector<const char*> profiles;
  std::vector<int> hands = {kLeftHand, kRightHand};
};

// Facts of the engines' public sources: FOpenXRController of Unreal's OpenXRInput, OpenXrController of Chromium's
// device/vr, BaseInput::CreateLegacyActions of OpenComposite, OpenXRInput of Unity's plugin, OpenXRAPI::action_create
// of Godot, oxri_init of StereoKit, GHOST_XrAction of Blender.
const std::vector<Pattern>& Patterns() {
  using enum Declared;
  static const std::vector<Pattern> all{
      {"Unreal", true, kNoPath, true, false, false, {kSimple, kTouch, kIndex}},
      {"Chromium WebXR", true, kNoPath, true, true, true, {kSimple, kTouch, kIndex}},
      {"OpenComposite", true, kNoPath, true, false, false, {kTouch, kIndex}},
      {"Unity", false, kBothHands, false, true, false, {kTouch, kSimple}},
      {"Godot", false, kBothHands, false, false, false, {kSimple, kTouch, kIndex}},
      {"StereoKit", false, kBothHands, false, true, false, {kTouch, kSimple}},
      {"Blender", true, kItsHand, false, true, false, {kTouch, kIndex, kSimple}},
      {"one path, at XR_NULL_PATH", true, kItsHand, true, false, false, {kTouch}},
      {"both paths, an action per hand", true, kBothHands, true, false, false, {kTouch}},
      {"simple controller only", true, kNoPath, true, false, false, {kSimple}},
      {"left hand only", true, kNoPath, true, false, false, {kTouch}, {kLeftHand}},
      {"right hand only", false, kBothHands, true, true, false, {kTouch}, {kRightHand}},
  };
  return all;
}

// Who is there. `hand`: the pen's.
struct World {
  bool service = true;
  bool pen = true;
  int hand = kRightHand;
  std::array<bool, 2> controller{true, true};
};
struct Order {
  const char* name;
  std::vector<World> steps;
};

// For a pen of hand `h`; the other hand is `o`.
std::vector<Order> Orders(int h) {
  const int o = 1 - h;
  const auto world = [](bool service, bool pen, int hand, bool left, bool right) {
    return World{service, pen, hand, {left, right}};
  };
  const auto without = [&](bool pen) { return world(true, pen, h, h != kLeftHand, h != kRightHand); };
  const World both = world(true, true, h, true, true), gone = world(true, false, h, true, true);
  const World none = world(false, false, h, true, true), alone = world(true, true, h, false, false);
  return {
      {"pen first", {alone, both, gone}},
      {"controller first", {none, both, gone}},
      {"pen comes back", {both, gone, both, gone, both}},
      {"controller leaves", {none, both, without(true), without(false), gone, both}},
      {"omnid killed", {alone, both, none, both, none}},
      {"hand switched", {none, both, world(true, true, o, true, true), both, gone}},
  };
}

enum class Who { kNobody, kPen, kController };

template <class Values>
auto& Of(Values& values, int hand) {
  return values[static_cast<std::size_t>(hand)];
}

XrPosef Unit() { return {{0, 0, 0, 1}, {0, 0, 0}}; }

class Engine {
 public:
  explicit Engine(const Pattern& pattern) : pattern_(pattern), app_(Options()) {
    omni_test_set_device("left", 0, nullptr);
    omni_test_set_device("right", 0, nullptr);
    MakeActions();
    if (pattern_.spaces_first) MakeSpaces();
    for (const char* profile : pattern_.profiles) EXPECT_EQ(app_.Suggest(profile, Bindings(profile)), XR_SUCCESS);
    AttachAll();
    for (const int hand : pattern_.hands) EXPECT_EQ(Locate(Of(spaces_, hand)).locationFlags, 0u) << "before a sync";
  }

  // The first deviation after each of `steps`; empty: none.
  std::string Run(const std::vector<World>& steps) {
    for (std::size_t i = 0; i < steps.size(); ++i) {
      Enter(steps[i]);
      std::string wrong = Settle(steps[i]);
      for (const int hand : pattern_.hands)
        if (wrong.empty()) wrong = Judge(hand, Truth(steps[i], hand));
      if (!wrong.empty()) return "step " + std::to_string(i) + ": " + wrong;
    }
    return CheckPenHaptics();
  }

  // The application leaves its session and begins another one with the same actions.
  void NextSession() {
    ASSERT_EQ(xrDestroySession(app_.session), XR_SUCCESS);
    app_.state = XR_SESSION_STATE_UNKNOWN;
    const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, app_.system};
    ASSERT_EQ(xrCreateSession(app_.instance, &info, &app_.session), XR_SUCCESS);
    if (pattern_.spaces_first) MakeSpaces();
    AttachAll();
    app_.PollUntilFocused();
  }

 private:
  static AppOptions Options() {
    AppOptions options;
    options.attach = false;
    return options;
  }

  Who Truth(const World& world, int hand) const {
    if (world.service && world.pen && world.hand == hand) return Who::kPen;
    return Of(world.controller, hand) ? Who::kController : Who::kNobody;
  }
  XrPath At(int hand) const { return pattern_.at_null ? XR_NULL_PATH : hand == kLeftHand ? app_.left : app_.right; }

  XrAction Make(XrActionSet set, const std::string& name, XrActionType type, int hand) {
    XrActionCreateInfo info{XR_TYPE_ACTION_CREATE_INFO};
    std::snprintf(info.actionName, sizeof(info.actionName), "%s", name.c_str());
    std::snprintf(info.localizedActionName, sizeof(info.localizedActionName), "%s", name.c_str());
    info.actionType = type;
    const XrPath both[] = {app_.left, app_.right};
    info.countSubactionPaths = pattern_.declared == Declared::kBothHands ? 2 : 1;
    if (pattern_.declared == Declared::kNoPath) info.countSubactionPaths = 0;
    info.subactionPaths = pattern_.declared == Declared::kItsHand ? &both[hand] : both;
    XrAction action = XR_NULL_HANDLE;
    EXPECT_EQ(xrCreateAction(set, &info, &action), XR_SUCCESS);
    return action;
  }

  void MakeActions() {
    for (const int hand : pattern_.hands) {
      const bool first = hand == pattern_.hands.front();
      const std::string side = pattern_.action_per_hand ? kSides[hand] : "hands";
      if (first || pattern_.set_per_hand) sets_.push_back(app_.MakeSet(("engine_" + side).c_str(), 0));
      if (!first && !pattern_.action_per_hand) {
        Of(poses_, hand) = poses_[0];
        Of(presses_, hand) = presses_[0];
        Of(haptics_, hand) = haptics_[0];
        continue;
      }
      Of(poses_, hand) = Make(sets_.back(), side + "_pose", XR_ACTION_TYPE_POSE_INPUT, hand);
      Of(presses_, hand) = Make(sets_.back(), side + "_press", XR_ACTION_TYPE_FLOAT_INPUT, hand);
      Of(haptics_, hand) = Make(sets_.back(), side + "_haptic", XR_ACTION_TYPE_VIBRATION_OUTPUT, hand);
    }
  }

  void MakeSpaces() {
    local_ = app_.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    for (const int hand : pattern_.hands) {
      Of(spaces_, hand) = app_.ActionSpace(Of(poses_, hand), At(hand), Unit());
      Of(probes_, hand) = app_.ActionSpace(app_.pose, hand == kLeftHand ? app_.left : app_.right, Unit());
    }
  }

  // With a probe, which shows by its subaction path whose the hand is.
  std::vector<Bound> Bindings(const char* profile) {
    std::vector<Bound> bindings;
    for (const int hand : pattern_.hands) {
      const std::string press = profile == kSimple ? "/input/select/click" : "/input/trigger/value";
      for (const std::string& path : {std::string("/input/grip/pose"), press, std::string("/output/haptic")})
        texts_.push_back(std::make_unique<std::string>(UserPath(hand) + path));
      const auto path = [&](std::size_t back) { return texts_[texts_.size() - back]->c_str(); };
      bindings.push_back({app_.pose, path(3)});
      bindings.push_back({Of(poses_, hand), path(3)});
      bindings.push_back({Of(presses_, hand), path(2)});
      bindings.push_back({Of(haptics_, hand), path(1)});
    }
    return bindings;
  }

  void AttachAll() {
    std::vector<XrActionSet> sets = sets_;
    sets.push_back(app_.set);
    const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr,
                                             static_cast<std::uint32_t>(sets.size()), sets.data()};
    ASSERT_EQ(xrAttachSessionActionSets(app_.session, &info), XR_SUCCESS);
    if (!pattern_.spaces_first) MakeSpaces();
    active_.clear();
    for (const XrActionSet set : sets) active_.push_back({set, XR_NULL_PATH});
  }

  bool Suggests(const char* profile) const {
    for (const char* suggested : pattern_.profiles)
      if (std::string(suggested) == profile) return true;
    return false;
  }

  void Enter(const World& world) {
    const bool touch = Suggests(kTouch);
    for (const int hand : {kLeftHand, kRightHand}) {
      const bool there = Of(world.controller, hand);
      omni_test_set_device(kSides[hand], there, touch ? kTouch : kSimple);
      if (there && touch) omni_test_set_float((UserPath(hand) + "/input/trigger/value").c_str(), 0.75f);
    }
    if (!world.service) {
      EXPECT_EQ(CheckPenHaptics(), "");
      service_.reset();
      played_before_ = 0;
      return;
    }
    if (!service_) {
      service_ = std::make_unique<FakeService>();
      service_->Set(protocol::InputIndex::kTipForce, 0.25f);
      service_->Set(protocol::InputIndex::kSelect, 1);
      wished_hand_ = -1;
    }
    if (wished_hand_ != world.hand) {
      protocol::AppSettings settings;
      settings.hand = world.hand == kLeftHand ? protocol::HandSetting::kLeft : protocol::HandSetting::kRight;
      service_->Wish(settings);
      wished_hand_ = world.hand;
    }
    service_->SetFlags(world.pen ? protocol::kToolPoseValid | protocol::kToolTracked : 0u);
  }

  void Sync() {
    if (service_) service_->Fill();
    ASSERT_EQ(app_.SyncSets(active_), XR_SUCCESS);
  }

  XrSpaceLocation Locate(XrSpace space) const {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(space, local_, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    return location;
  }
  // The pen's place is in the middle, the controllers are 20 cm beside it.
  Who WhoIsAt(XrSpace space, int hand) const {
    const XrSpaceLocation location = Locate(space);
    if (!(location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT)) return Who::kNobody;
    const float beside_m = hand == kLeftHand ? -0.2f : 0.2f;
    if (std::fabs(location.pose.position.x) < 0.01f) return Who::kPen;
    EXPECT_NEAR(location.pose.position.x, beside_m, 0.01f);
    return Who::kController;
  }

  // Syncs until the layer has noticed the new state of the world.
  std::string Settle(const World& world) {
    const std::int64_t end = Now_ns() + Patience_ns();
    for (;;) {
      Sync();
      app_.Poll();
      bool settled = true;
      for (const int hand : pattern_.hands) settled = settled && WhoIsAt(Of(probes_, hand), hand) == Truth(world, hand);
      if (settled) return {};
      if (Now_ns() > end) return "the layer has not noticed it";
      Pause_ms(3);
    }
  }

  std::string Judge(int hand, Who who) {
    std::ostringstream wrong;
    const bool there = who != Who::kNobody, pen = who == Who::kPen;
    const bool touch = Suggests(kTouch);
    if (app_.PoseActive(Of(poses_, hand), At(hand)) != there) wrong << "pose active " << !there << "; ";
    if (const Who at = WhoIsAt(Of(spaces_, hand), hand); at != who)
      wrong << "located at " << static_cast<int>(at) << ", should be " << static_cast<int>(who) << "; ";
    const XrActionStateFloat press = app_.Float(Of(presses_, hand), At(hand));
    if ((press.isActive == XR_TRUE) != there) wrong << "press active " << !there << "; ";
    const float value = pen ? (touch ? 0.25f : 1.0f) : there && touch ? 0.75f : 0.0f;
    if (std::fabs(press.currentState - value) > 1e-6f) wrong << "press " << press.currentState << "; ";
    if (app_.Profile(app_.Path(UserPath(hand))).empty() == there) wrong << "profile; ";
    wrong << JudgeSources(hand, who) << JudgeHaptics(hand, who);
    return wrong.str().empty() ? std::string() : std::string(kSides[hand]) + ": " + wrong.str();
  }

  std::string JudgeSources(int hand, Who who) const {
    const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr,
                                                    Of(poses_, hand)};
    std::array<XrPath, 8> sources{};
    std::uint32_t count = 0;
    EXPECT_EQ(xrEnumerateBoundSourcesForAction(app_.session, &info, 8, &count, sources.data()), XR_SUCCESS);
    std::string found;
    int of_hand = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (app_.Text(sources[i]).rfind(UserPath(hand) + "/", 0) != 0) continue;
      ++of_hand;
      const XrInputSourceLocalizedNameGetInfo name{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr, sources[i],
                                                   XR_INPUT_SOURCE_LOCALIZED_NAME_INTERACTION_PROFILE_BIT};
      std::array<char, 128> text{};
      std::uint32_t length = 0;
      EXPECT_EQ(xrGetInputSourceLocalizedName(app_.session, &name, 128, &length, text.data()), XR_SUCCESS);
      found = text.data();
    }
    if (of_hand != (who == Who::kNobody ? 0 : 1)) return std::to_string(of_hand) + " bound sources; ";
    const bool named_pen = found.find("Omni") != std::string::npos;
    return named_pen == (who == Who::kPen) ? std::string() : "bound source of " + found + "; ";
  }

  std::string JudgeHaptics(int hand, Who who) {
    std::array<OmniTestHaptics, 2> before{}, after{};
    for (const int side : {kLeftHand, kRightHand}) omni_test_haptics(kSides[side], &Of(before, side));
    const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, Of(haptics_, hand), At(hand)};
    const XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, 1'000'000, 150.0f, 0.1f};
    EXPECT_EQ(xrApplyHapticFeedback(app_.session, &info,
                                    static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration))),
              XR_SUCCESS);
    pen_haptics_ += who == Who::kPen ? 1 : 0;
    std::ostringstream wrong;
    for (const int side : {kLeftHand, kRightHand}) {
      omni_test_haptics(kSides[side], &Of(after, side));
      const auto shaken = Of(after, side).count - Of(before, side).count;
      if (shaken != (side == hand && who == Who::kController ? 1u : 0u))
        wrong << kSides[side] << " controller shaken " << shaken << " times; ";
    }
    return wrong.str();
  }

  // All that the pen should have played, and no more.
  std::string CheckPenHaptics() {
    if (!service_) return {};
    const auto played = [&] { return service_->heard().haptics.size(); };
    const std::size_t wanted = std::exchange(pen_haptics_, 0) + played_before_;
    if (!Eventually([&] { return played() >= wanted; })) return "the pen played too little";
    played_before_ = played();
    return played_before_ == wanted ? std::string() : "the pen played too much";
  }

  const Pattern& pattern_;
  std::unique_ptr<FakeService> service_;
  App app_;
  int wished_hand_ = -1;
  std::size_t pen_haptics_ = 0, played_before_ = 0;
  std::vector<XrActionSet> sets_;
  std::vector<XrActiveActionSet> active_;
  std::vector<std::unique_ptr<std::string>> texts_;
  std::array<XrAction, 2> poses_{}, presses_{}, haptics_{};
  std::array<XrSpace, 2> spaces_{}, probes_{};
  XrSpace local_ = XR_NULL_HANDLE;
};

class Engines : public testing::TestWithParam<std::size_t> {};

TEST_P(Engines, HandFollowsWhoHoldsIt) {
  const Pattern& pattern = Patterns()[GetParam()];
  std::string row;
  int wrong = 0;
  for (std::size_t i = 0; i < Orders(kRightHand).size(); ++i) {
    std::string problem;
    for (const int hand : {kLeftHand, kRightHand}) {
      omni_test_reset();
      const Order order = Orders(hand)[i];
      Engine engine(pattern);
      if (const std::string why = engine.Run(order.steps); !why.empty())
        problem += std::string(order.name) + ", pen in the " + kSides[hand] + " hand, " + why + "\n";
    }
    wrong += !problem.empty();
    row += std::string("  ") + Orders(kRightHand)[i].name + (problem.empty() ? ": right" : ": WRONG");
    EXPECT_EQ(problem, "") << pattern.name;
  }
  std::printf("[ figure   ] %s: %d of 6 orders wrong:%s\n", pattern.name, wrong, row.c_str());
}

// Two sessions one after another: nothing of the first one sticks to the actions.
TEST_P(Engines, SecondSessionFollowsToo) {
  const Pattern& pattern = Patterns()[GetParam()];
  omni_test_reset();
  Engine engine(pattern);
  const std::vector<Order> orders = Orders(kRightHand);
  EXPECT_EQ(engine.Run(orders[1].steps), "");
  ASSERT_NO_FATAL_FAILURE(engine.NextSession());
  EXPECT_EQ(engine.Run(orders[3].steps), "") << "second session";
}

std::string NameOf(const testing::TestParamInfo<std::size_t>& info) {
  std::string name = Patterns()[info.param].name;
  std::erase_if(name, [](unsigned char c) { return std::isalnum(c) == 0; });
  return name;
}

INSTANTIATE_TEST_SUITE_P(Of, Engines, testing::Range(std::size_t{0}, Patterns().size()), NameOf);

}  // namespace test_engines
}  // namespace omni::test
