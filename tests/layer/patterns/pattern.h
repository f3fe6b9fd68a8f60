// How a program calls OpenXR, as data: tests/layer/patterns/data has a file per program, docs/howto/engines.md the
// keys.
#pragma once

#include <string>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::test::patterns {

inline constexpr int kLeftHand = 0, kRightHand = 1;
inline constexpr const char* kSides[] = {"left", "right"};

// An action `per_hand` is made twice, once for each hand; else once for both.
enum class SubactionPaths { kNone, kItsHand, kBothHands };
struct PatternAction {
  std::string name;
  XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
  bool per_hand = false;
  SubactionPaths paths = SubactionPaths::kNone;
};

struct PatternBinding {
  std::string action;
  int hand;
  std::string path;  // "/user/hand/left/input/trigger/value"
};
struct PatternProfile {
  std::string path;
  std::string needs;  // this extension; empty: none
  std::vector<PatternBinding> bindings;
};

// What the program makes of one device: that of a hand, or a pen of its own kind.
struct PatternDevice {
  std::string pose, press, haptic;  // actions; an empty one: it has none
  bool at_null = false;             // spaces, states and vibrations at XR_NULL_PATH, else at the hand's subaction path
  float threshold = 0.5f;           // of a float that means a press
  bool press_checks_active = false;
};

enum class ActionSets { kOne, kPerHand, kPerProfile };
enum class Spaces { kBeforeSuggestions, kBeforeAttach, kAfterAttach, kFirstUse };
enum class ProfileRead { kNever, kAtEvent, kAtSyncAfterEvent, kEachFrame };
enum class NameBy { kNothing, kProfile, kBoundSources, kLocalizedName };
enum class ModelBy { kProfile, kMsft, kInteraction };
enum class NewSession { kSameActions, kNewActions, kNewInstance };
enum class Rejected { kNextProfile, kEnds };

struct Pattern {
  std::string name, id, version, notes;
  std::vector<std::string> sources;
  bool program = true;                  // else a shape of calls that no program of the list has
  std::vector<std::string> extensions;  // asked for where they are offered
  std::vector<int> hands;
  ActionSets sets = ActionSets::kOne;
  std::vector<PatternAction> actions;
  std::vector<PatternProfile> profiles;  // in the order of their suggestions
  bool suggests_before_session = false;
  bool suggests_each_alone_first = false;
  bool asks_profile_in_first_session = false;  // a session of its own, that ends before the real one
  Rejected rejected = Rejected::kNextProfile;
  Spaces spaces = Spaces::kAfterAttach;
  bool space_per_profile = false;
  NewSession new_session = NewSession::kSameActions;
  XrReferenceSpaceType base = XR_REFERENCE_SPACE_TYPE_LOCAL;
  bool new_base_at_recentre = false;
  ProfileRead profile_read = ProfileRead::kNever;
  // When a hand counts as there.
  bool needs_profile = false, needs_pose_active = false, needs_press_active = false;
  XrSpaceLocationFlags all_flags = 0, any_flag = 0;
  bool with_velocity = false;
  PatternDevice hand;
  std::vector<PatternDevice> pen;  // at most one: it takes the pen for that, not for a hand's controller
  NameBy name_by = NameBy::kNothing;
  ModelBy model_by = ModelBy::kProfile;

  const PatternAction* Find(const std::string& action) const;
  const PatternProfile* FindProfile(const std::string& path) const;
};

// All files of the folder, by name; throws with file and key if one is wrong.
const std::vector<Pattern>& Patterns();

}  // namespace omni::test::patterns
