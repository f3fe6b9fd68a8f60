// A reference model of OpenXR's action system with one pen and one runtime, written from the specification and the
// layer's documented choices (docs/howto/openxr-layer.md), not from the layer's code: slow, plain, all from scratch at
// every sync. Of the layer it uses the profile data only.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "layer/src/actions/profile.h"

namespace omni::test {

enum class At { kNull, kLeft, kRight };  // XR_NULL_PATH and the hands' top-level paths

struct ModelAction {
  int set = 0;
  XrActionType type = XR_ACTION_TYPE_BOOLEAN_INPUT;
  bool left = false;  // declared subaction paths
  bool right = false;
  bool HasSubaction(At at) const { return at == At::kLeft ? left : at == At::kRight && right; }
  bool any_declared() const { return left || right; }
};

struct ModelSuggestion {
  std::string profile;
  int action = 0;
  std::string path;                                  // full
  std::optional<std::pair<float, float>> threshold;  // on, off
};

struct ModelPart {  // what a source reports
  bool active = false;
  float x = 0;
  float y = 0;
  std::int64_t t = 0;
};

struct ModelActiveSet {
  int set = 0;
  At at = At::kNull;
  std::uint32_t priority = 0;
};

struct ModelSync {
  bool focused = true;
  At hand = At::kRight;
  std::string preferred;
  bool pen_present = false;
  bool put_down = false;
  bool start_edges = false;
  std::uint64_t service = 0;
  std::vector<ModelActiveSet> active;
  protocol::InputSnapshot inputs;                   // times in ns of the same clock as `now`
  std::map<std::pair<int, At>, ModelPart> runtime;  // its answers after this sync
  std::int64_t now = 0;
};

struct ModelState {
  bool active = false;
  bool changed = false;
  float x = 0;
  float y = 0;
  std::int64_t last_change_earliest = 0;  // both 0 while inactive
  std::int64_t last_change_latest = 0;
};

enum class SpaceSource { kRuntime, kNobody, kPen };
struct ModelSpace {
  SpaceSource source = SpaceSource::kRuntime;
  std::string pose;  // local path, of the pen's profile
};

class ActionModel {
 public:
  ActionModel(const std::vector<layer::Profile>& profiles, std::vector<ModelAction> actions,
              std::vector<ModelSuggestion> suggestions, std::set<int> attached_sets);

  void Sync(const ModelSync& sync);

  // Empty: the runtime's own answer.
  std::optional<ModelState> State(int action, At at) const;
  ModelSpace Space(int action, At at) const;
  std::set<std::string> PenSources(int action) const;
  // The pen's profile at its hand; empty: the runtime's.
  std::string Profile() const { return owner_ ? profile_ : std::string(); }

 private:
  struct Wire {  // a suggestion that the pen serves
    const ModelSuggestion* suggestion = nullptr;
    std::string source;      // local path of the component, pose, or vector
    std::string identifier;  // local path without the component
    bool pressed = false;
    std::uint32_t presses = 0;  // of its click, up to here accounted for
    std::uint32_t releases = 0;
  };
  struct Memory {
    ModelState state;
    ModelPart pen;
    ModelPart runtime;
    char device = 0;  // 'p' pen, 'r' runtime: where a pose comes from
    bool of_layer = false;
  };

  std::set<std::string> PlacesOf(int action) const;
  At Meant(int action, At at) const;
  const layer::Profile* FindProfile(const std::string& path) const;
  bool Choose();
  std::vector<Wire> WiresOf(const layer::Profile& profile) const;
  bool ActionIsActive(int action, const ModelSync& sync, std::uint32_t* priority) const;
  bool Suppressed(const Wire& wire, const ModelSync& sync) const;
  void StepEdges(const ModelSync& sync, bool start);
  ModelPart PenSays(int action, const ModelSync& sync) const;
  ModelPart Scalar(const Wire& wire, const layer::Component& component, const ModelSync& sync) const;
  ModelPart RuntimeSays(int action, At at, const ModelSync& sync) const;
  void Remember(int action, At at, const ModelPart& runtime, const ModelPart& pen, const ModelSync& sync);

  const std::vector<layer::Profile>& profiles_;
  const std::vector<ModelAction> actions_;
  const std::vector<ModelSuggestion> suggestions_;
  const std::set<int> attached_;
  At hand_ = At::kRight;
  std::string preferred_;
  std::string profile_;
  std::vector<Wire> wires_;
  std::map<std::pair<int, At>, Memory> memory_;
  bool owner_ = false;
  bool recording_ = false;
  bool synced_ = false;
  bool was_focused_ = false;
  bool put_down_ = false;
  std::uint64_t service_ = 0;
  ModelSync last_;
};

}  // namespace omni::test
