// Plays a program: makes its calls in its order, and keeps what the program would show of each device.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/layer/patterns/pattern.h"

namespace omni::test::patterns {

inline constexpr int kPenDevice = 2;  // beside kLeftHand and kRightHand, where Pattern::pen has one

// One device as the program sees it in this frame.
struct Seen {
  bool there = false;
  XrVector3f position{};
  bool tracked = false;
  bool pressed = false;
};

class Player {
 public:
  explicit Player(const Pattern& pattern);
  ~Player();
  Player(const Player&) = delete;
  Player& operator=(const Player&) = delete;

  // Polls, synchronizes and reads once.
  void Frame();
  void RestartSession();
  void RestartInstance();

  const Seen& seen(int device) const { return seen_[static_cast<std::size_t>(device)]; }
  bool focused() const { return state_ == XR_SESSION_STATE_FOCUSED; }
  XrResult Vibrate(int device) const;
  // As the program remembers it; empty: none.
  const std::string& profile(int hand) const { return profile_[static_cast<std::size_t>(hand)]; }
  // Of the sources that are bound to the hand's pose.
  std::vector<std::string> Names(int hand) const;
  // Of the models that the program would draw in that hand, each with what identifies it.
  std::vector<std::uint64_t> Models(int hand) const;
  // What made the program give up; empty: it runs.
  const std::string& ended() const { return ended_; }

 private:
  static void Must(XrResult result, const std::string& what);  // throws
  static std::set<std::string> OfferedExtensions();
  struct Made {
    std::string set;  // its key
    int hand;         // -1: for both
    XrAction action;
  };

  void StartInstance();
  void StopInstance();
  void StartSession(bool with_actions);
  void StopSession(bool with_actions);
  void AskProfileInFirstSession();

  void MakeActions();
  XrAction MakeAction(XrActionSet set, const PatternAction& action, int hand) const;
  void DestroyActions();
  void Suggest();
  XrResult SuggestBindings(const PatternProfile& profile, const std::vector<XrActionSuggestedBinding>& bindings) const;
  void AttachAll();
  void MakeSpaces();
  XrSpace SpaceOf(const PatternDevice& device, int index);
  void MakeBase();
  void BeginWhenReady(XrSessionState state);
  void PollUntil(XrSessionState state);

  void Poll();
  void ReadProfiles();
  void Read(const PatternDevice& device, int index);
  bool IsThere(const PatternDevice& device, int index, Seen& seen);
  bool IsPressed(const PatternDevice& device, int index, bool& active) const;
  const PatternDevice& DeviceOf(int index) const { return index == kPenDevice ? pattern_.pen[0] : pattern_.hand; }
  XrPath PathOf(const PatternDevice& device, int index) const;
  XrAction ActionOf(const std::string& name, int index) const;
  std::string SetOf(const PatternProfile& profile, int hand) const;
  XrPath Path(const std::string& text) const;
  std::string Text(XrPath path) const;
  std::string CurrentProfile(int hand) const;
  bool Has(const std::string& extension) const { return enabled_.count(extension) > 0; }
  std::vector<int> Devices() const;

  const Pattern& pattern_;
  std::string ended_;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  XrSession session_ = XR_NULL_HANDLE;
  XrSessionState state_ = XR_SESSION_STATE_UNKNOWN;
  bool running_ = false;
  bool profile_event_ = false;
  std::set<std::string> enabled_;
  std::map<std::string, XrActionSet> sets_;
  std::map<std::string, std::vector<Made>> actions_;  // by name
  std::map<std::pair<int, std::string>, XrSpace> spaces_;
  XrSpace base_ = XR_NULL_HANDLE;
  std::array<XrPath, 2> hand_paths_{};
  std::array<std::string, 2> profile_;
  std::array<Seen, 3> seen_{};
};

}  // namespace omni::test::patterns
