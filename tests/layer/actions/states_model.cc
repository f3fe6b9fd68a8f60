// Random applications, syncs, pens and runtimes: the layer's action states against the reference model.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <random>
#include <set>
#include <sstream>

#include "layer/src/actions/session_actions.h"
#include "tests/layer/actions/action_model.h"

namespace omni::test {
namespace test_states_model {

constexpr XrPath kPathOf[] = {XR_NULL_PATH, 11, 12};  // by At
constexpr int kSequences = 8000;
constexpr int kSyncsOfASequence = 25;

const std::vector<layer::Profile>& AllProfiles() {
  static const std::vector<layer::Profile> all = layer::LoadProfiles();
  return all;
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  int Below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  bool Chance(int percent) { return Below(100) < percent; }
  template <class T>
  const T& Of(const std::vector<T>& all) {
    return all[static_cast<std::size_t>(Below(static_cast<int>(all.size())))];
  }

 private:
  std::mt19937_64 engine_;
};

class FakeRuntime : public layer::RuntimeStates {
 public:
  std::map<std::pair<const layer::Action*, XrPath>, ModelPart> answers;
  layer::StatePart Query(const layer::Action& action, XrPath subaction) const override {
    const auto found = answers.find({&action, subaction});
    if (found == answers.end()) return {};
    const ModelPart& p = found->second;
    if (!p.active) return {};
    return {true, {p.x, p.y}, p.t};
  }
};

// One application: its sets, actions and suggestions, as the layer and as the model know them.
struct Scenario {
  Dice dice;
  std::vector<std::shared_ptr<layer::ActionSet>> sets;
  std::vector<std::shared_ptr<layer::Action>> actions;
  std::vector<ModelAction> model_actions;
  std::vector<ModelSuggestion> suggestions;
  std::set<int> attached;
  std::vector<std::string> profiles;
  ModelSync sync;

  explicit Scenario(std::uint64_t seed) : dice(seed) {
    MakeActions();
    MakeSuggestions();
    sync.now = 1'000'000'000;
    sync.service = 100;
  }

  void MakeActions() {
    const int set_count = 1 + dice.Below(3);
    for (int i = 0; i < set_count; ++i) {
      auto set = std::make_shared<layer::ActionSet>();
      set->priority = static_cast<std::uint32_t>(dice.Below(3));
      sets.push_back(std::move(set));
      if (i == 0 || dice.Chance(85)) attached.insert(i);
    }
    const std::vector<XrActionType> types{XR_ACTION_TYPE_BOOLEAN_INPUT,   XR_ACTION_TYPE_BOOLEAN_INPUT,
                                          XR_ACTION_TYPE_FLOAT_INPUT,     XR_ACTION_TYPE_VECTOR2F_INPUT,
                                          XR_ACTION_TYPE_POSE_INPUT,      XR_ACTION_TYPE_POSE_INPUT,
                                          XR_ACTION_TYPE_VIBRATION_OUTPUT};
    for (int i = 2 + dice.Below(7); i > 0; --i) {
      ModelAction m;
      m.set = dice.Below(set_count);
      m.type = dice.Of(types);
      if (dice.Chance(70)) {
        m.left = dice.Chance(70);
        m.right = dice.Chance(70);
      }
      auto action = std::make_shared<layer::Action>();
      action->set = sets[static_cast<std::size_t>(m.set)];
      action->type = m.type;
      if (m.left) action->subactions.push_back(kPathOf[1]);
      if (m.right) action->subactions.push_back(kPathOf[2]);
      actions.push_back(std::move(action));
      model_actions.push_back(m);
    }
  }

  // A path of the profile, its parent, or one that it does not have.
  std::string SomePath(const layer::Profile& profile) {
    std::string path;
    const int kind = dice.Below(10);
    if (kind < 6) {
      path = dice.Of(profile.components).path;
    } else if (kind < 8) {
      path = dice.Of(profile.poses).path;
    } else {
      path = kind == 8 ? "/output/haptic" : "/input/thumbstick";
    }
    if (dice.Chance(25)) path = path.substr(0, path.rfind('/'));
    return std::string(dice.Chance(35) ? "/user/hand/left" : "/user/hand/right") + path;
  }

  void MakeSuggestions() {
    for (int i = 1 + dice.Below(3); i > 0; --i) {
      const layer::Profile& profile = dice.Of(AllProfiles());
      if (std::find(profiles.begin(), profiles.end(), profile.path) != profiles.end()) continue;
      profiles.push_back(profile.path);
      for (int k = 1 + dice.Below(14); k > 0; --k) {
        ModelSuggestion s{profile.path, dice.Below(static_cast<int>(actions.size())), SomePath(profile), std::nullopt};
        if (dice.Chance(15)) {
          const float off = 0.05f + 0.1f * static_cast<float>(dice.Below(9));
          s.threshold = {{std::min(1.0f, off + 0.1f * static_cast<float>(dice.Below(3))), off}};
        }
        suggestions.push_back(s);
      }
    }
  }

  layer::Suggestions ForLayer() const {
    layer::Suggestions out;
    for (const ModelSuggestion& s : suggestions) {
      layer::Suggestion entry{actions[static_cast<std::size_t>(s.action)], s.path, std::nullopt};
      if (s.threshold) entry.threshold = layer::AnalogThreshold{s.threshold->first, s.threshold->second, {}, {}};
      out[s.profile].push_back(std::move(entry));
    }
    return out;
  }

  void MoveInput(std::size_t index) {
    protocol::InputValue& input = sync.inputs.components[index];
    const bool is_axis = index == static_cast<std::size_t>(protocol::InputIndex::kThumbstickX) ||
                         index == static_cast<std::size_t>(protocol::InputIndex::kThumbstickY);
    const float value = 0.1f * static_cast<float>(is_axis ? dice.Below(21) - 10 : dice.Below(11));
    if (input.value <= 0.5f && value > 0.5f) ++input.press_count;
    if (input.value > 0.5f && value <= 0.5f) ++input.release_count;
    if (input.value < value || input.value > value) input.t_change_ns = sync.now - 1 - dice.Below(9'000'000);
    input.value = value;
  }

  // Random changes until the next sync.
  void Live() {
    sync.now += 10'000'000;
    for (int moves = dice.Below(8); moves > 0; --moves)
      MoveInput(static_cast<std::size_t>(dice.Below(static_cast<int>(protocol::kInputCount))));
    sync.focused = dice.Chance(sync.focused ? 93 : 60);
    sync.start_edges = dice.Chance(3);
    if (dice.Chance(8)) sync.pen_present = !sync.pen_present;
    if (dice.Chance(6)) sync.put_down = !sync.put_down;
    if (dice.Chance(2)) ++sync.service;
    if (dice.Chance(3)) sync.hand = sync.hand == At::kRight ? At::kLeft : At::kRight;
    if (dice.Chance(3)) sync.preferred = dice.Chance(50) ? dice.Of(profiles) : dice.Of(AllProfiles()).path;
    sync.active.clear();
    for (const int set : attached) {
      const std::uint32_t priority =
          dice.Chance(15) ? static_cast<std::uint32_t>(dice.Below(4)) : sets[static_cast<std::size_t>(set)]->priority;
      if (dice.Chance(70)) sync.active.push_back({set, At::kNull, priority});
      if (dice.Chance(15)) sync.active.push_back({set, At::kLeft, priority});
      if (dice.Chance(15)) sync.active.push_back({set, At::kRight, priority});
    }
    sync.runtime.clear();
    for (int action = 0; action < static_cast<int>(actions.size()); ++action)
      for (const At at : {At::kNull, At::kLeft, At::kRight})
        if (dice.Chance(60))
          sync.runtime[{action, at}] = {true, 0.25f * static_cast<float>(dice.Below(5)),
                                        0.25f * static_cast<float>(dice.Below(9) - 4),
                                        sync.now - 1 - dice.Below(9'000'000)};
    for (auto& [key, part] : sync.runtime) {
      const XrActionType type = model_actions[static_cast<std::size_t>(key.first)].type;
      if (type != XR_ACTION_TYPE_VECTOR2F_INPUT) part.y = 0;
      if (type == XR_ACTION_TYPE_BOOLEAN_INPUT) part.x = part.x > 0.5f ? 1.0f : 0.0f;
      if (type == XR_ACTION_TYPE_POSE_INPUT) part.x = part.y = 0;
    }
  }

  layer::SyncInput InputForLayer(FakeRuntime& runtime) const {
    layer::SyncInput input;
    input.focused = sync.focused;
    input.choice = {sync.hand == At::kLeft ? layer::Hand::kLeft : layer::Hand::kRight, sync.preferred};
    input.pen.present = sync.pen_present;
    input.pen.service_instance = sync.service;
    input.pen.inputs = sync.inputs;
    input.put_down = sync.put_down;
    input.start_edges = sync.start_edges;
    for (const ModelActiveSet& active : sync.active)
      input.active.push_back(
          {sets[static_cast<std::size_t>(active.set)], kPathOf[static_cast<int>(active.at)], active.priority});
    runtime.answers.clear();
    for (const auto& [key, part] : sync.runtime)
      runtime.answers[{actions[static_cast<std::size_t>(key.first)].get(), kPathOf[static_cast<int>(key.second)]}] =
          part;
    return input;
  }
};

std::string Compare(const layer::ActionState* is, const std::optional<ModelState>& wanted) {
  std::ostringstream why;
  if (!is != !wanted) {
    why << (is ? "the layer answers, the runtime should" : "the runtime answers, the layer should");
    return why.str();
  }
  if (!is) return {};
  if (is->active != wanted->active) why << "active " << is->active << ", should be " << wanted->active << "; ";
  if (is->changed != wanted->changed) why << "changed " << is->changed << ", should be " << wanted->changed << "; ";
  if (is->value.x != wanted->x || is->value.y != wanted->y)
    why << "value " << is->value.x << "," << is->value.y << ", should be " << wanted->x << "," << wanted->y << "; ";
  if (!(is->last_change >= wanted->last_change_earliest && is->last_change <= wanted->last_change_latest))
    why << "changed at " << is->last_change << ", should be in " << wanted->last_change_earliest << ".."
        << wanted->last_change_latest << "; ";
  // The conformance layer's invariants.
  if (!is->active && (is->changed || is->last_change != 0 || is->value.x != 0 || is->value.y != 0))
    why << "inactive but not zero; ";
  if (is->changed && is->last_change == 0) why << "changed at no time; ";
  return why.str();
}

std::string ComparePose(const layer::ActionState* is, const std::optional<ModelState>& wanted) {
  if (!is != !wanted) return is ? "the layer answers, the runtime should" : "the runtime answers, the layer should";
  if (!is || is->active == wanted->active) return {};
  return std::string("pose active ") + (is->active ? "1" : "0");
}

std::string CompareSpace(const layer::SessionActions& layer, const std::shared_ptr<layer::Action>& action, At at,
                         const ModelSpace& wanted) {
  layer::Space space;
  space.action = action;
  space.subaction = kPathOf[static_cast<int>(at)];
  layer.UpdateServedBy(space);
  const int served = space.served_by;
  const SpaceSource is = served == layer::kServedByRuntime  ? SpaceSource::kRuntime
                         : served == layer::kServedByNobody ? SpaceSource::kNobody
                                                            : SpaceSource::kPen;
  if (is != wanted.source) return "the space is served by " + std::to_string(served);
  if (is != SpaceSource::kPen) return {};
  for (const layer::PoseComponent& pose : layer.profile()->poses)
    if (pose.path == wanted.pose && &pose.X_TP == &layer.PosePart(served)) return {};
  return "the space is at another pose than " + wanted.pose;
}

std::string CompareAction(const Scenario& scenario, const layer::SessionActions& layer, const ActionModel& model,
                          int i) {
  const auto& action = scenario.actions[static_cast<std::size_t>(i)];
  const ModelAction& m = scenario.model_actions[static_cast<std::size_t>(i)];
  for (const At at : {At::kNull, At::kLeft, At::kRight}) {
    if (at != At::kNull && !m.HasSubaction(at)) continue;
    std::string why;
    if (m.type == XR_ACTION_TYPE_POSE_INPUT) {
      why = ComparePose(layer.FindState(*action, kPathOf[static_cast<int>(at)]), model.State(i, at));
      if (why.empty()) why = CompareSpace(layer, action, at, model.Space(i, at));
    } else if (m.type != XR_ACTION_TYPE_VIBRATION_OUTPUT) {
      why = Compare(layer.FindState(*action, kPathOf[static_cast<int>(at)]), model.State(i, at));
    }
    if (!why.empty()) return "at " + std::to_string(static_cast<int>(at)) + ": " + why;
  }
  const std::vector<std::string> listed = layer.BoundSources(*action);
  const std::set<std::string> sources(listed.begin(), listed.end());
  return sources == model.PenSources(i) && sources.size() == listed.size() ? std::string() : "other bound sources";
}

struct Seen {  // that the scenarios cover what they are meant to
  long active = 0, changed = 0, pen_spaces = 0, hand_overs = 0;
};

std::string RunScenario(std::uint64_t seed, Seen& seen) {
  Scenario scenario(seed);
  layer::SessionActions layer(AllProfiles(), {layer::Hand::kRight, ""}, {kPathOf[1], kPathOf[2]});
  std::vector<std::shared_ptr<layer::ActionSet>> sets;
  for (const int set : scenario.attached) sets.push_back(scenario.sets[static_cast<std::size_t>(set)]);
  layer.Attach(sets, scenario.actions, scenario.ForLayer());
  ActionModel model(AllProfiles(), scenario.model_actions, scenario.suggestions, scenario.attached);
  const layer::RuntimeClock clock(XR_NULL_HANDLE, nullptr);
  FakeRuntime runtime;
  for (int step = 0; step < kSyncsOfASequence; ++step) {
    scenario.Live();
    const bool owned = layer.pen_owns_hand();
    layer.Sync(scenario.InputForLayer(runtime), runtime, clock, scenario.sync.now);
    model.Sync(scenario.sync);
    seen.hand_overs += owned != layer.pen_owns_hand();
    const std::string where = "seed " + std::to_string(seed) + ", sync " + std::to_string(step);
    const std::string profile = layer.profile() ? layer.profile()->path : std::string();
    if (profile != model.Profile()) return where + ": profile " + profile + ", should be " + model.Profile();
    for (int i = 0; i < static_cast<int>(scenario.actions.size()); ++i) {
      const std::string why = CompareAction(scenario, layer, model, i);
      if (!why.empty()) return where + ", action " + std::to_string(i) + " " + why;
      const layer::ActionState* any = layer.FindState(*scenario.actions[static_cast<std::size_t>(i)], XR_NULL_PATH);
      seen.active += any && any->active;
      seen.changed += any && any->changed;
      seen.pen_spaces += model.Space(i, At::kNull).source == SpaceSource::kPen;
    }
  }
  return {};
}

TEST(StatesModel, RandomScenariosMatchTheReferenceModel) {
  Seen seen;
  for (std::uint64_t seed = 1; seed <= kSequences; ++seed) {
    const std::string why = RunScenario(seed, seen);
    ASSERT_EQ(why, "");
  }
  std::printf("%d sequences of %d syncs: %ld active states, %ld changes, %ld spaces of the pen, %ld hand-overs\n",
              kSequences, kSyncsOfASequence, seen.active, seen.changed, seen.pen_spaces, seen.hand_overs);
  EXPECT_GT(seen.active, 10'000);
  EXPECT_GT(seen.changed, 1'000);
  EXPECT_GT(seen.pen_spaces, 1'000);
  EXPECT_GT(seen.hand_overs, 1'000);
}

}  // namespace test_states_model
}  // namespace omni::test
