// Every program over every scenario: does it see, press, shake, name and draw what is really in each hand? The truth is
// what the test has fed into the service and the runtime.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "tests/layer/patterns/page.h"
#include "tests/layer/patterns/player.h"
#include "tests/layer/patterns/simulation.h"

namespace omni::test::patterns {

const char* NameOf(Who who) {
  return who == Who::kPen ? "the pen" : who == Who::kController ? "the controller" : "no device";
}

double Distance_m(const XrVector3f& a, const XrVector3f& b) { return std::hypot(a.x - b.x, a.y - b.y, a.z - b.z); }

// Whose profile is another one than the pen's, or the same, where the program suggests it.
const char* Controllers(const Pattern& pattern, bool same) {
  const std::vector<const char*> order = same ? std::vector{kTouch, kSimple} : std::vector{kIndex, kTouch, kSimple};
  for (const char* profile : order)
    if (pattern.FindProfile(profile)) return profile;
  return kSimple;
}

class Judge {
 public:
  // With the runtime's controllers of that profile; the pen prefers `preferred`.
  Judge(const Pattern& pattern, const char* controllers, const std::string& preferred = {})
      : pattern_(pattern), controllers_(controllers), simulation_(controllers, preferred) {}

  // The first deviation; empty: none.
  std::string Run(const Scenario& scenario) {
    for (std::size_t i = 0; i < scenario.steps.size(); ++i) {
      std::string wrong = RunStep(scenario.steps[i]);
      if (wrong.empty()) wrong = stray_;
      if (player_ && !player_->ended().empty()) wrong += "the program ends: " + player_->ended();
      if (!wrong.empty()) return std::string(scenario.name) + ", step " + std::to_string(i) + ": " + wrong;
    }
    return {};
  }

 private:
  std::string RunStep(const Step& step) {
    std::string wrong;
    if (step.pressed) {
      simulation_.PressPen(true);
      wrong = Settle([&] { return Pressed(simulation_.world().hand, Who::kPen); }, "pressed before: ");
      if (!wrong.empty()) return wrong;
    }
    simulation_.Enter(step.world);
    if (step.world.focused) simulation_.PressPen(false);
    if (!player_) {
      player_ = std::make_unique<Player>(pattern_);
    } else if (step.restart == Restart::kSession) {
      player_->RestartSession();
    } else if (step.restart == Restart::kInstance) {
      player_->RestartInstance();
    }
    if (step.restart != Restart::kNone) models_of_controllers_.clear();
    wrong = Settle([&] { return Poses(); }, "pose: ");
    if (wrong.empty()) wrong = Presses();
    if (wrong.empty()) wrong = Haptics();
    for (const int hand : pattern_.hands) {
      if (wrong.empty()) wrong = ProfileAndName(hand);
      if (wrong.empty()) wrong = Model(hand);
    }
    return wrong;
  }

  // False: it took long, on a busy machine, so that the pen's samples may be too old by now: nothing to judge.
  bool Frame() {
    constexpr std::int64_t kShort_ns = 20'000'000;
    const std::int64_t begin_ns = Now_ns();
    simulation_.Fill();
    player_->Frame();
    if (Now_ns() - begin_ns > kShort_ns) return false;
    for (const int device : {kLeftHand, kRightHand, kPenDevice})
      if (player_->seen(device).there && !IsSomewhere(device) && stray_.empty())
        stray_ = "a frame shows device " + std::to_string(device) + " where nothing is";
    return true;
  }

  // In no frame may a hand show another place than the pen's or its controller's, not even while they change.
  bool IsSomewhere(int device) const {
    const bool tip = device == kPenDevice;
    const int hand = tip ? kRightHand : device;
    const XrVector3f& seen = player_->seen(device).position;
    for (const Who who : {Who::kPen, Who::kController})
      if (Distance_m(seen, simulation_.Place(who, hand, pattern_.base, tip)) < 0.001 ||
          Distance_m(seen, simulation_.PlaceBefore(who, hand, pattern_.base, tip)) < 0.001)
        return true;
    return false;
  }

  // Frames until nothing is wrong, then a few more, in which nothing may become wrong.
  template <class Find>
  std::string Settle(Find find, const char* what) {
    std::string wrong;
    if (!Eventually([&] { return Frame() && (wrong = find()).empty(); })) return what + wrong;
    for (int more = 0; more < 4;) {
      if (!Frame()) continue;
      ++more;
      if (!(wrong = find()).empty()) return std::string(what) + "afterwards " + wrong;
    }
    return {};
  }

  // Which device of the program shows what holds that hand; the others of the hand show nothing.
  int DeviceOf(int hand) const {
    return simulation_.Truth(hand) == Who::kPen && !pattern_.pen.empty() ? kPenDevice : hand;
  }

  std::string Poses() const {
    std::ostringstream wrong;
    bool pen_device_used = pattern_.pen.empty();
    for (const int hand : pattern_.hands) {
      const int device = DeviceOf(hand);
      pen_device_used = pen_device_used || device == kPenDevice;
      if (device != hand && player_->seen(hand).there) wrong << kSides[hand] << " shows something beside the pen; ";
      wrong << Pose(player_->seen(device), simulation_.Truth(hand), hand, device);
    }
    if (!pen_device_used && player_->seen(kPenDevice).there) wrong << "a pen is shown; ";
    return wrong.str();
  }

  std::string Pose(const Seen& seen, Who who, int hand, int device) const {
    constexpr XrSpaceLocationFlags kTracked =
        XR_SPACE_LOCATION_POSITION_TRACKED_BIT | XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT;
    const bool tracked = who == Who::kController || simulation_.pen_tracked();
    const bool there = who != Who::kNobody && (tracked || (pattern_.all_flags & kTracked) == 0);
    const std::string of = kSides[hand] + std::string(", where ") + NameOf(who) + " is, ";
    if (seen.there != there) return of + (there ? "shows nothing; " : "shows something; ");
    if (!there) return {};
    const double off_m = Distance_m(seen.position, simulation_.Place(who, hand, pattern_.base, device == kPenDevice));
    if (!(off_m < 0.001)) return of + "is off by " + std::to_string(off_m) + " m; ";
    return seen.tracked == tracked ? std::string() : of + (tracked ? "is not TRACKED; " : "is TRACKED; ");
  }

  // Presses each device that is there, alone. A controller on the desk, in the pen's hand, presses nothing.
  std::string Presses() {
    std::string wrong = Settle([&] { return Pressed(-1, Who::kNobody); }, "released: ");
    for (const int hand : {kLeftHand, kRightHand}) {
      if (wrong.empty() && simulation_.HasController(hand)) {
        simulation_.PressController(hand, true);
        wrong = Settle([&] { return Pressed(hand, Who::kController); }, "controller pressed: ");
        simulation_.PressController(hand, false);
      }
      if (wrong.empty() && simulation_.Truth(hand) == Who::kPen) {
        simulation_.PressPen(true);
        wrong = Settle([&] { return Pressed(hand, Who::kPen); }, "pen pressed: ");
        simulation_.PressPen(false);
      }
      if (wrong.empty()) wrong = Settle([&] { return Pressed(-1, Who::kNobody); }, "released again: ");
    }
    return wrong;
  }

  std::string Pressed(int pressed_hand, Who pressed) const {
    std::ostringstream wrong;
    for (const int hand : pattern_.hands) {
      const bool wanted = hand == pressed_hand && simulation_.Truth(hand) == pressed && pressed != Who::kNobody;
      if (player_->seen(DeviceOf(hand)).pressed != wanted) wrong << kSides[hand] << " pressed " << !wanted << "; ";
    }
    return wrong.str();
  }

  static std::uint32_t Vibrations(int hand) {
    OmniTestHaptics haptics{};
    omni_test_haptics(kSides[hand], &haptics);
    return haptics.count;
  }

  std::string Haptics() {
    if (pattern_.hand.haptic.empty()) return {};
    for (const int hand : pattern_.hands) {
      const std::uint32_t before[] = {Vibrations(kLeftHand), Vibrations(kRightHand)};
      const XrResult result = player_->Vibrate(DeviceOf(hand));
      if (XR_FAILED(result)) return std::string("haptic: ") + kSides[hand] + ": " + Name(result);
      pen_vibrations_ += simulation_.Truth(hand) == Who::kPen ? 1 : 0;
      for (const int side : {kLeftHand, kRightHand}) {
        const std::uint32_t wanted = side == hand && simulation_.Truth(hand) == Who::kController ? 1 : 0;
        if (Vibrations(side) - before[side] != wanted)
          return std::string("haptic for ") + kSides[hand] + ": wrong for the controller at " + kSides[side];
      }
    }
    if (!Eventually([&] { return simulation_.pen_vibrations() >= pen_vibrations_; })) return "haptic: not at the pen";
    return simulation_.pen_vibrations() == pen_vibrations_ ? std::string() : "haptic: too often at the pen";
  }

  std::string ProfileAndName(int hand) const {
    if (!simulation_.world().focused) return {};
    const Who who = simulation_.Truth(hand);
    const std::string of = std::string("name of ") + kSides[hand] + ", " + NameOf(who) + ": ";
    if (pattern_.profile_read != ProfileRead::kNever) {
      const std::string& profile = player_->profile(hand);
      const bool right = who == Who::kController ? profile == controllers_ : profile.empty() == (who == Who::kNobody);
      if (!right) return of + "profile \"" + profile + "\"";
    }
    if (pattern_.name_by == NameBy::kNothing || pattern_.name_by == NameBy::kProfile) return {};
    const std::vector<std::string> names = player_->Names(hand);
    if (names.size() != (who == Who::kNobody ? 0u : 1u)) return of + std::to_string(names.size()) + " bound sources";
    if (names.empty() || pattern_.name_by == NameBy::kBoundSources) return {};
    const bool named_pen = names[0].find("Omni") != std::string::npos;
    return named_pen == (who == Who::kPen) ? std::string() : of + names[0];
  }

  // A controller has its model, an empty hand none, the pen none of a controller.
  std::string Model(int hand) {
    if (pattern_.model_by == ModelBy::kProfile || !simulation_.world().focused) return {};
    const Who who = simulation_.Truth(hand);
    const std::vector<std::uint64_t> models = player_->Models(hand);
    const std::string of = std::string("model of ") + kSides[hand] + ", " + NameOf(who) + ": ";
    if (who == Who::kController) models_of_controllers_.insert(models.begin(), models.end());
    if (models.size() != 1 && who == Who::kController) return of + std::to_string(models.size());
    if (!models.empty() && who == Who::kNobody) return of + "there is one";
    for (const std::uint64_t model : models)
      if (who == Who::kPen && models_of_controllers_.count(model) > 0) return of + "the controller's";
    return {};
  }

  const Pattern& pattern_;
  const char* const controllers_;  // the runtime's
  Simulation simulation_;
  std::unique_ptr<Player> player_;
  std::size_t pen_vibrations_ = 0;
  std::string stray_;
  std::set<std::uint64_t> models_of_controllers_;
};

class Programs : public testing::TestWithParam<std::tuple<std::size_t, std::size_t>> {};

TEST_P(Programs, ShowsWhatHoldsEachHand) {
  const Pattern& pattern = Patterns()[std::get<0>(GetParam())];
  for (const int hand : {kRightHand, kLeftHand}) {
    const Scenario scenario = Scenarios(hand)[std::get<1>(GetParam())];
    EXPECT_EQ(Judge(pattern, Controllers(pattern, hand == kLeftHand)).Run(scenario), "")
        << pattern.name << ", pen in the " << kSides[hand] << " hand";
  }
}

std::string TestName(const testing::TestParamInfo<Programs::ParamType>& info) {
  return Patterns()[std::get<0>(info.param)].id + "_" + Scenarios(kRightHand)[std::get<1>(info.param)].id;
}

INSTANTIATE_TEST_SUITE_P(Of, Programs,
                         testing::Combine(testing::Range(std::size_t{0}, Patterns().size()),
                                          testing::Range(std::size_t{0}, Scenarios(kRightHand).size())),
                         TestName);

// A user's remedy where a program knows the MX Ink and its scene only hands.
TEST(Patterns, ProgramWithAPenOfItsOwnShowsAHandIfTouchIsPreferred) {
  for (Pattern pattern : Patterns()) {
    if (pattern.pen.empty()) continue;
    pattern.pen.clear();
    for (const int hand : {kRightHand, kLeftHand})
      for (const Scenario& scenario : Scenarios(hand))
        EXPECT_EQ(Judge(pattern, kIndex, kTouch).Run(scenario), "")
            << pattern.name << ", pen in the " << kSides[hand] << " hand";
  }
}

// Else a scenario would judge nothing.
TEST(Patterns, ProfilesBindThePoseAndThoseOfTheControllersThePress) {
  for (const Pattern& pattern : Patterns()) {
    for (const PatternProfile& profile : pattern.profiles) {
      std::set<std::string> bound;
      for (const PatternBinding& binding : profile.bindings) bound.insert(binding.action);
      const bool pens = !pattern.pen.empty() && bound.count(pattern.pen[0].pose) > 0;
      const PatternDevice& device = pens ? pattern.pen[0] : pattern.hand;
      EXPECT_EQ(bound.count(device.pose), 1u) << pattern.name << " " << profile.path;
      const bool used = profile.path == Controllers(pattern, false) || profile.path == Controllers(pattern, true);
      EXPECT_TRUE(bound.count(device.press) == 1 || !used) << pattern.name << " " << profile.path;
    }
    EXPECT_EQ(pattern.program, !pattern.version.empty()) << pattern.name;
  }
}

std::string Document(const std::string& name) {
  std::ifstream in(OMNI_SOURCE_DIR "/docs/howto/" + name);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Patterns, PageIsCurrent) {
  EXPECT_TRUE(Page() == Document("engines.md"))
      << "run " OMNI_BINARY_DIR "/bin/layer_patterns_page > docs/howto/engines.md";
}

TEST(Patterns, HeadsetPageNamesEveryProgram) {
  const std::string page = Document("headset.md");
  const std::size_t row = page.find("| pattern tested");
  ASSERT_NE(row, std::string::npos);
  const std::string tested = page.substr(row, page.find('\n', row) - row);
  for (const Pattern& pattern : Patterns())
    EXPECT_TRUE(!pattern.program || tested.find(pattern.name) != std::string::npos) << pattern.name;
}

}  // namespace omni::test::patterns
