#pragma once
// What the handles stand for. Actions and action sets outlive their handles while a session or a space still uses them
// (specification: destroying an action set does not disturb the sessions it is attached to).

#include <openxr/openxr.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "tests/runtime/graphics/graphics.h"
#include "tests/runtime/newer_openxr.h"
#include "tests/runtime/script.h"
#include "tests/runtime/world.h"

namespace omni::runtime {

enum class Kind : uint8_t {
  kNone,
  kInstance,
  kSession,
  kActionSet,
  kAction,
  kSpace,
  kHandTracker,
  kRenderModel,
  kRenderModelAsset,
  kSwapchain
};

struct Object {
  Kind kind;
  uint64_t handle = 0;
  explicit Object(Kind k) : kind(k) {}
  Object(const Object&) = delete;
  Object& operator=(const Object&) = delete;
  virtual ~Object() = default;
};

struct Instance;
struct Session;
struct ActionSet;

struct Action : Object {
  static constexpr Kind kKind = Kind::kAction;
  Action() : Object(kKind) {}
  ActionSet* set = nullptr;  // kept alive by whoever keeps the action alive: see Instance, Session, Space
  std::string name;
  std::string localized_name;
  XrActionType type{};
  std::vector<XrPath> subaction_paths;
};

struct ActionSet : Object {
  static constexpr Kind kKind = Kind::kActionSet;
  ActionSet() : Object(kKind) {}
  Instance* instance = nullptr;
  std::string name;
  std::string localized_name;
  uint32_t priority = 0;
  bool attached = false;  // to any session, ever: from then on it is immutable
  std::vector<std::shared_ptr<Action>> actions;
};

// An analogue source read as a boolean, with hysteresis.
struct Threshold {
  float on = 0.7f;
  float off = 0.5f;
};

struct Suggestion {
  const Action* action = nullptr;  // identity only
  int hand = -1;
  std::string path;  // below the hand
  Threshold threshold;
};
// By profile index; an empty entry means: never suggested.
using Suggestions = std::map<int, std::vector<Suggestion>>;

struct Bound {
  Source source;
  bool pressed = false;  // hysteresis of an analogue source read as a boolean
  Threshold threshold;
};

// Answers for one (action, subaction path), constant between two syncs.
struct Slot {
  XrPath subaction = XR_NULL_PATH;
  std::vector<Bound> bound;  // changes with the interaction profile only
  bool active = false;
  bool changed = false;
  float x = 0;
  float y = 0;
  XrTime change_time = 0;
  Source pose_source;
  int pose_hand = -1;  // of XR_NULL_PATH, which stays with the hand that fed it first; -1: none has
};

struct ActionState {
  std::shared_ptr<Action> action;
  std::vector<Slot> slots;  // [0]: XR_NULL_PATH; then one per declared subaction path
};

// What an application has done of the steps that lead to a Vulkan binding. Vulkan's own types, untyped.
struct VulkanSetup {
  bool asked = false;                              // for the requirements
  PFN_xrVoidFunction get_instance_proc = nullptr;  // with which the instance below was made; null: none was
  void* instance = nullptr;                        // made by xrCreateVulkanInstanceKHR
  void* physical_device = nullptr;                 // that the application has to use; null: it did not ask
};

struct Instance : Object {
  static constexpr Kind kKind = Kind::kInstance;
  Instance() : Object(kKind) {}
  uint32_t serial = 0;
  bool lost = false;
  bool headless = false;
  bool version_1_1 = false;  // the application asked for OpenXR 1.1
  std::vector<std::string> extensions;
  bool Enabled(std::string_view extension) const {
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
  }
  bool binding_modification = false;
  bool analog_threshold = false;
  bool set_priorities = false;  // XR_EXT_active_action_set_priority
  VulkanSetup vulkan;
  bool opengl_asked = false;  // for OpenGL's requirements
  std::vector<std::string> paths;
  std::unordered_map<std::string, uint32_t> path_ids;
  std::deque<XrEventDataBuffer> events;
  uint32_t events_lost = 0;
  std::vector<std::shared_ptr<ActionSet>> action_sets;
  std::vector<std::shared_ptr<Session>> sessions;
  Suggestions suggestions;
  Script script;
};

// A controller's model, as enumerated since the last sync.
struct SessionModel {
  XrRenderModelIdEXT id = 0;
  int hand = 0;
};

struct Session : Object {
  static constexpr Kind kKind = Kind::kSession;
  Session() : Object(kKind) {}
  Instance* instance = nullptr;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  bool running = false;
  bool exit_requested = false;
  bool lost = false;

  bool attached = false;
  std::vector<std::shared_ptr<ActionSet>> sets;
  Suggestions suggestions;                  // as they were when the sets were attached
  std::array<int, kHands> profile{-1, -1};  // current, index into Profiles()
  std::array<uint32_t, kHands> profile_epoch{0, 0};
  std::unordered_map<const Action*, ActionState> states;

  bool frame_waited = false;
  bool frame_begun = false;
  bool in_step = false;  // has ended a frame since it began
  XrTime next_frame = 0;
  uint64_t frames_shown = 0;  // accepted, with layers

  std::vector<SessionModel> models;
  XrRenderModelIdEXT last_model = 0;
  std::array<bool, kHands> identified{};  // the application has the cacheId of this hand's model

  std::shared_ptr<Graphics> graphics;  // null: headless

  std::vector<uint64_t> children;  // handles: spaces, hand trackers, render models, swapchains
};

struct RenderModel : Object {
  static constexpr Kind kKind = Kind::kRenderModel;
  RenderModel() : Object(kKind) {}
  Session* session = nullptr;
  XrRenderModelIdEXT id = 0;
  int hand = 0;
};

struct Swapchain : Object {
  static constexpr Kind kKind = Kind::kSwapchain;
  Swapchain() : Object(kKind) {}
  Session* session = nullptr;
  XrSwapchainCreateInfo info{};
  uint32_t count = 0;
  std::unique_ptr<Images> images;
  uint32_t next = 0;              // image that is acquired next
  std::deque<uint32_t> acquired;  // and not released, the oldest first
  bool waited = false;            // for the oldest
  int released = -1;              // the newest; -1: none was
};

struct RenderModelAsset : Object {
  static constexpr Kind kKind = Kind::kRenderModelAsset;
  RenderModelAsset() : Object(kKind) {}
  Session* session = nullptr;
  int hand = 0;
};

struct Space : Object {
  static constexpr Kind kKind = Kind::kSpace;
  Space() : Object(kKind) {}
  Session* session = nullptr;
  XrPosef offset = kIdentity;
  XrReferenceSpaceType reference{};
  // Action spaces only. The set is held too, since the action points to it.
  std::shared_ptr<Action> action;
  std::shared_ptr<ActionSet> set;
  XrPath subaction = XR_NULL_PATH;
  std::shared_ptr<RenderModel> model;  // spaces of models only
};

struct HandTracker : Object {
  static constexpr Kind kKind = Kind::kHandTracker;
  HandTracker() : Object(kKind) {}
  Session* session = nullptr;
  int hand = 0;
};

}  // namespace omni::runtime
