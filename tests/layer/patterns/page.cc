#include "tests/layer/patterns/page.h"

#include <sstream>

#include "tests/layer/patterns/pattern.h"
#include "tests/layer/patterns/scenario.h"

namespace omni::test::patterns {
namespace {

constexpr const char* kBegin = R"(# How programs call OpenXR, and what is tested of them

Generated from tests/layer/patterns by `layer_patterns_page`; a test compares the two.

A *pattern* is a file in [tests/layer/patterns/data](../../tests/layer/patterns/data). It says which actions a program makes, which
profiles it suggests and in which order, when it makes its spaces, what it reads each frame, and what it does when a call fails. These are
facts from the program's public sources, or from its documentation where there are none; no code was taken. A player makes those calls, over
the layer, the test runtime and a service that the test plays ([test-runtime.md](test-runtime.md)). It draws nothing: that a program works
is known only once it was run ([headset.md](headset.md), section 8).

## Programs

| program | version | sources | what is special |
|---|---|---|---|
)";

constexpr const char* kCalls = R"(
## How they call

| program | action sets | suggests | order of profiles | a rejected suggestion | spaces | new session |
|---|---|---|---|---|---|---|
)";

constexpr const char* kReads = R"(
| program | base space | shows a hand if | current profile | press | vibration | name | model |
|---|---|---|---|---|---|---|---|
)";

constexpr const char* kScenarios = R"(
## Scenarios

| scenario | what happens |
|---|---|
)";

constexpr const char* kTable = R"(
## What is tested

Each cell is a test, `layer.Of/Programs.ShowsWhatHoldsEachHand/PROGRAM_SCENARIO`: once with the pen in the right hand beside Index
controllers, where each change of a hand changes its profile, and once in the left hand beside Touch controllers, where none does, as the
pen is a Touch controller to most programs. It says what is judged after every step, for both hands: `p` the pose (whose it is, its place
within 1 mm, TRACKED or not), `r` press and release, `h` the haptic, `n` the name or current profile, `m` the model. A dash: the program
does not ask. The truth is what the test has fed into the service and the runtime. In between, no frame may show a hand where neither pen
nor controller is.

| program |)";

constexpr const char* kEnd = R"(
A program with a pen of its own (LÖVR) shows the pen in a hand if the Touch controller is preferred (`profile` in [apps.md](apps.md)), in
all scenarios too. Five further files, `shape_*.json`, are shapes of calls that no program of the list has; they go through the same
scenarios.

To add a program, write its file (the keys: tests/layer/patterns/pattern.h), then run
`build/release/bin/layer_patterns_page > docs/howto/engines.md`.
)";

std::string Cell(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "<br>") + line;
  return text;
}

std::string ProfilesOf(const Pattern& pattern) {
  std::string text;
  for (const PatternProfile& profile : pattern.profiles) {
    const std::string name = profile.path.substr(sizeof("/interaction_profiles/") - 1);
    text += (text.empty() ? "" : ", ") + (profile.needs.empty() ? name : "(" + name + ")");
  }
  return text;
}

std::string SpacesOf(const Pattern& pattern) {
  std::string text = pattern.spaces == Spaces::kFirstUse            ? "at first use"
                     : pattern.spaces == Spaces::kAfterAttach       ? "after the attachment"
                     : pattern.spaces == Spaces::kBeforeSuggestions ? "before the suggestions"
                                                                    : "before the attachment";
  text += pattern.hand.at_null ? ", at XR_NULL_PATH" : ", at the hand";
  return text + (pattern.space_per_profile ? ", one per profile" : "");
}

std::string NeedsOf(const Pattern& pattern) {
  std::vector<std::string> needs;
  if (pattern.needs_profile) needs.push_back("it has a current profile");
  if (pattern.needs_pose_active) needs.push_back("its pose is active");
  if (pattern.needs_press_active) needs.push_back("its trigger is active");
  const auto flags = [](XrSpaceLocationFlags set, const char* joint) {
    std::string text;
    const auto add = [&](XrSpaceLocationFlags flag, const char* name) {
      if ((set & flag) != 0) text += (text.empty() ? "" : joint) + std::string(name);
    };
    add(XR_SPACE_LOCATION_POSITION_VALID_BIT, "POSITION_VALID");
    add(XR_SPACE_LOCATION_ORIENTATION_VALID_BIT, "ORIENTATION_VALID");
    add(XR_SPACE_LOCATION_POSITION_TRACKED_BIT, "POSITION_TRACKED");
    add(XR_SPACE_LOCATION_ORIENTATION_TRACKED_BIT, "ORIENTATION_TRACKED");
    return text;
  };
  if (pattern.all_flags != 0) needs.push_back(flags(pattern.all_flags, " and "));
  if (pattern.any_flag != 0) needs.push_back(flags(pattern.any_flag, " or "));
  return Cell(needs);
}

std::string CallsRow(const Pattern& pattern) {
  std::ostringstream row;
  row << "| " << pattern.name << " | "
      << (pattern.sets == ActionSets::kOne       ? "one"
          : pattern.sets == ActionSets::kPerHand ? "per hand"
                                                 : "per profile")
      << " | " << (pattern.suggests_before_session ? "before" : "after") << " xrCreateSession"
      << (pattern.suggests_each_alone_first ? ", each binding alone first" : "") << " | " << ProfilesOf(pattern)
      << " | " << (pattern.rejected == Rejected::kEnds ? "ends it" : "next profile") << " | " << SpacesOf(pattern)
      << " | "
      << (pattern.new_session == NewSession::kSameActions  ? "same actions"
          : pattern.new_session == NewSession::kNewActions ? "new actions"
                                                           : "new instance")
      << " |\n";
  return row.str();
}

std::string ReadsRow(const Pattern& pattern) {
  const bool is_float = pattern.Find(pattern.hand.press)->type == XR_ACTION_TYPE_FLOAT_INPUT;
  std::ostringstream row;
  row << "| " << pattern.name << " | " << (pattern.base == XR_REFERENCE_SPACE_TYPE_LOCAL ? "LOCAL" : "STAGE")
      << (pattern.new_base_at_recentre ? ", a new one at each recentring" : "") << " | " << NeedsOf(pattern) << " | "
      << (pattern.profile_read == ProfileRead::kNever              ? "never asked"
          : pattern.profile_read == ProfileRead::kAtEvent          ? "asked at its event"
          : pattern.profile_read == ProfileRead::kAtSyncAfterEvent ? "asked in the sync after its event"
                                                                   : "asked each frame")
      << " | ";
  if (is_float) row << "float over " << pattern.hand.threshold;
  if (!is_float) row << "boolean";
  row << (pattern.hand.press_checks_active ? "" : ", isActive ignored") << " | "
      << (pattern.hand.haptic.empty() ? "none" : "yes") << " | "
      << (pattern.name_by == NameBy::kNothing        ? "none"
          : pattern.name_by == NameBy::kProfile      ? "its own, by profile"
          : pattern.name_by == NameBy::kBoundSources ? "its own, by bound source"
                                                     : "xrGetInputSourceLocalizedName")
      << " | "
      << (pattern.model_by == ModelBy::kProfile ? "its own"
          : pattern.model_by == ModelBy::kMsft  ? "XR_MSFT_controller_model"
                                                : "XR_EXT_interaction_render_model")
      << " |\n";
  return row.str();
}

std::string JudgedRow(const Pattern& pattern, std::size_t scenarios) {
  const std::string judged = std::string("p r ") + (pattern.hand.haptic.empty() ? "-" : "h") + " " +
                             (pattern.name_by == NameBy::kNothing ? "-" : "n") + " " +
                             (pattern.model_by == ModelBy::kProfile ? "-" : "m");
  std::string row = "| " + pattern.name + " |";
  for (std::size_t i = 0; i < scenarios; ++i) row += " " + judged + " |";
  return row + "\n";
}

}  // namespace

std::string Page() {
  const std::vector<Scenario> scenarios = Scenarios(kRightHand);
  std::string head, rule, sources = kBegin, calls = kCalls, reads = kReads, what = kScenarios, judged;
  for (const Scenario& scenario : scenarios) {
    head += std::string(" ") + scenario.name + " |";
    rule += "---|";
    what += std::string("| ") + scenario.name + " | " + scenario.what + " |\n";
  }
  for (const Pattern& pattern : Patterns()) {
    if (!pattern.program) continue;
    sources +=
        "| " + pattern.name + " | " + pattern.version + " | " + Cell(pattern.sources) + " | " + pattern.notes + " |\n";
    calls += CallsRow(pattern);
    reads += ReadsRow(pattern);
    judged += JudgedRow(pattern, scenarios.size());
  }
  calls +=
      "\nIn parentheses: only where the profile's extension is offered. Of these, only that of MX Ink is: by the "
      "layer.\n";
  return sources + calls + reads + what + kTable + head + "\n|---|" + rule + "\n" + judged + kEnd;
}

}  // namespace omni::test::patterns
