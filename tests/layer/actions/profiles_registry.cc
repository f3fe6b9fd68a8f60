// The profiles' paths against the registry's (specification, "Interaction Profile Paths" and the extensions' chapters):
// on each hand all of them and no others.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "layer/src/actions/profile.h"

namespace omni::test {
namespace test_profiles_registry {

// "trigger/value" is /input/trigger/value; poses grip and aim and the haptic output are on all of them.
struct RegistryRow {
  const char* path;
  const char* extension;  // null: core
  const char* both;
  const char* left;
  const char* right;
};

constexpr const char* kStick = " thumbstick/x thumbstick/y thumbstick/click";
constexpr RegistryRow kRegistry[] = {
    {"khr/simple_controller", nullptr, "select/click menu/click", "", ""},
    {"khr/generic_controller", "XR_KHR_generic_controller",
     "primary/click secondary/click squeeze/value trigger/value grip_surface/pose STICK", "", ""},
    {"htc/vive_controller", nullptr,
     "system/click squeeze/click menu/click trigger/click trigger/value trackpad/x trackpad/y trackpad/click "
     "trackpad/touch",
     "", ""},
    {"microsoft/motion_controller", nullptr,
     "menu/click squeeze/click trigger/value STICK trackpad/x trackpad/y trackpad/click trackpad/touch", "", ""},
    {"samsung/odyssey_controller", "XR_EXT_samsung_odyssey_controller",
     "menu/click squeeze/click trigger/value STICK trackpad/x trackpad/y trackpad/click trackpad/touch", "", ""},
    {"oculus/touch_controller", nullptr,
     "squeeze/value trigger/value trigger/touch STICK thumbstick/touch thumbrest/touch",
     "x/click x/touch y/click y/touch menu/click", "a/click a/touch b/click b/touch system/click"},
    {"valve/index_controller", nullptr,
     "system/click system/touch a/click a/touch b/click b/touch squeeze/value squeeze/force trigger/click "
     "trigger/value "
     "trigger/touch STICK thumbstick/touch trackpad/x trackpad/y trackpad/force trackpad/touch",
     "", ""},
    {"hp/mixed_reality_controller", "XR_EXT_hp_mixed_reality_controller",
     "menu/click squeeze/value trigger/value STICK", "x/click y/click", "a/click b/click"},
    {"bytedance/pico4_controller", "XR_BD_controller_interaction",
     "system/click trigger/click trigger/value trigger/touch STICK thumbstick/touch squeeze/click squeeze/value",
     "x/click x/touch y/click y/touch menu/click", "a/click a/touch b/click b/touch"},
    {"bytedance/pico_neo3_controller", "XR_BD_controller_interaction",
     "menu/click system/click trigger/click trigger/value trigger/touch STICK thumbstick/touch squeeze/click "
     "squeeze/value",
     "x/click x/touch y/click y/touch", "a/click a/touch b/click b/touch"},
    {"htc/vive_cosmos_controller", "XR_HTC_vive_cosmos_controller_interaction",
     "shoulder/click squeeze/click trigger/click trigger/value STICK thumbstick/touch", "x/click y/click menu/click",
     "a/click b/click system/click"},
    {"htc/vive_focus3_controller", "XR_HTC_vive_focus3_controller_interaction",
     "squeeze/click squeeze/touch squeeze/value trigger/click trigger/touch trigger/value STICK thumbstick/touch "
     "thumbrest/touch",
     "x/click y/click menu/click", "a/click b/click system/click"},
    {"logitech/mx_ink_stylus_logitech", "XR_LOGITECH_mx_ink_stylus_interaction",
     "system/click cluster_front_logitech/click cluster_front_logitech/double_tap_logitech "
     "cluster_middle_logitech/force "
     "cluster_back_logitech/click cluster_back_logitech/double_tap_logitech dock_logitech/docked_logitech "
     "tip_logitech/force tip_logitech/pose",
     "", ""},
};

// With 1.1 and all extensions that add paths: what they add is on every profile.
constexpr const char* kAdded =
    "grip_surface/pose palm_ext/pose pinch_ext/pose poke_ext/pose tip_omnix1/pose tip_omnix1/force";

std::set<std::string> PathsOf(const std::string& list) {
  std::string expanded = list;
  if (const auto at = expanded.find("STICK"); at != expanded.npos) expanded.replace(at, 5, kStick);
  std::set<std::string> paths{"/input/grip/pose", "/input/aim/pose"};
  std::istringstream words(expanded);
  for (std::string word; words >> word;) paths.insert("/input/" + word);
  return paths;
}

std::set<std::string> Listed(const layer::Profile& profile, layer::Hand hand, const std::vector<std::string>& enabled) {
  std::set<std::string> paths;
  for (const layer::Component& c : profile.components)
    if (c.IsOnHand(hand) && layer::HasPath(profile, hand, c.path, enabled)) paths.insert(c.path);
  for (const layer::PoseComponent& pose : profile.poses)
    if (layer::HasPath(profile, hand, pose.path, enabled)) paths.insert(pose.path);
  return paths;
}

std::string Difference(const std::set<std::string>& a, const std::set<std::string>& b) {
  std::string out;
  for (const std::string& path : a) out += b.count(path) ? "" : path + " ";
  return out;
}

TEST(ProfilesRegistry, ProfilePathsMatchTheRegistryExactly) {
  const std::vector<layer::Profile> profiles = layer::LoadProfiles();
  ASSERT_EQ(profiles.size(), std::size(kRegistry) + 1) << "one more: our own";
  for (const RegistryRow& row : kRegistry) {
    const auto profile = std::find_if(profiles.begin(), profiles.end(), [&](const layer::Profile& p) {
      return p.path == layer::FullProfilePath(row.path);
    });
    ASSERT_NE(profile, profiles.end()) << row.path;
    EXPECT_EQ(profile->extension, row.extension ? row.extension : "") << row.path;
    EXPECT_EQ(profile->haptics, std::vector<std::string>{"/output/haptic"}) << row.path;
    for (const layer::Hand hand : {layer::Hand::kLeft, layer::Hand::kRight}) {
      const std::string own = hand == layer::Hand::kLeft ? row.left : row.right;
      const std::set<std::string> wanted = PathsOf(std::string(row.both) + " " + own);
      const std::set<std::string> is = Listed(*profile, hand, {});
      EXPECT_EQ(Difference(wanted, is), "") << row.path << " lacks it";
      EXPECT_EQ(Difference(is, wanted), "") << row.path << " has it, the registry does not";
      std::set<std::string> more = PathsOf(std::string(row.both) + " " + own + " " + kAdded);
      if (std::string(row.path) == "oculus/touch_controller") {
        more.insert("/input/trigger/proximity");
        more.insert("/input/thumb_resting_surfaces/proximity");
      }
      const std::set<std::string> with_all = Listed(
          *profile, hand, {"1.1", "XR_EXT_palm_pose", "XR_EXT_hand_interaction", "XR_OMNIX1_stylus_interaction"});
      EXPECT_EQ(Difference(more, with_all) + Difference(with_all, more), "") << row.path << " with all extensions";
    }
  }
}

// [input-bound-sources] names for users: every source has a name, and no two of a hand have the same.
TEST(ProfilesRegistry, SourceNamesAreUniquePerHand) {
  for (const layer::Profile& profile : layer::LoadProfiles()) {
    for (const layer::Hand hand : {layer::Hand::kLeft, layer::Hand::kRight}) {
      std::set<std::string> names;
      for (const layer::Component& c : profile.components) {
        if (!c.IsOnHand(hand) || !c.requires_any.empty()) continue;
        EXPECT_TRUE(names.insert(c.name).second) << profile.path << ": " << c.name;
      }
      for (const layer::PoseComponent& pose : profile.poses)
        EXPECT_TRUE(names.insert(pose.name).second) << profile.path << ": " << pose.name;
    }
  }
}

// A person with nothing but a pen can select, and has a second and a menu button wherever a profile has two more.
TEST(ProfilesRegistry, EveryProfileMapsSelectAndMenuToThePen) {
  for (const layer::Profile& profile : layer::LoadProfiles()) {
    for (const layer::Hand hand : {layer::Hand::kLeft, layer::Hand::kRight}) {
      std::set<int> sources;
      for (const layer::Component& c : profile.components)
        if (c.IsOnHand(hand)) sources.insert({c.source, c.click_source});
      EXPECT_TRUE(sources.count(static_cast<int>(protocol::InputIndex::kSelect))) << profile.path;
      EXPECT_TRUE(sources.count(static_cast<int>(protocol::InputIndex::kMenu))) << profile.path;
    }
  }
}

}  // namespace test_profiles_registry
}  // namespace omni::test
