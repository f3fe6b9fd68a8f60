#include "service/tools/align/align.h"

#include <algorithm>

#include "service/alignment/rigid.h"

namespace omni::tools {
namespace {

// One step in the axes of the base, which the person faces: the turn is about its z.
struct KeyAction {
  char key;
  double right, away, up, turn;
};
constexpr KeyAction kActions[] = {
    {'d', 1, 0, 0, 0}, {'a', -1, 0, 0, 0}, {'w', 0, 1, 0, 0}, {'s', 0, -1, 0, 0},
    {'r', 0, 0, 1, 0}, {'f', 0, 0, -1, 0}, {'[', 0, 0, 0, 1}, {']', 0, 0, 0, -1},
};
// ESC [ A to D are the arrows, ESC [ 5 ~ and ESC [ 6 ~ are Page Up and Page Down.
struct SequenceEnd {
  char byte, key;
};
constexpr SequenceEnd kSequences[] = {{'A', 'w'}, {'B', 's'}, {'C', 'd'}, {'D', 'a'}, {'5', 'r'}, {'6', 'f'}};

constexpr double kTurnPerStep_rad_m = 1.75;  // 0.5 degrees for 5 mm
constexpr double kStepMin_m = 1e-3, kStepMax_m = 0.05;
constexpr char kEscape = '\033';

}  // namespace

Nudge::Does Nudge::Act(char action) {
  const auto found = std::find_if(std::begin(kActions), std::end(kActions),
                                  [action](const KeyAction& row) { return row.key == action; });
  if (found == std::end(kActions)) return Does::kNothing;
  const base::Vec3 step{step_m_ * found->right, step_m_ * found->away, step_m_ * found->up};
  const base::Vec3 shift = alignment::TransformPoint({.orientation = now_.orientation, .position_m = {}}, step);
  now_ = alignment::NudgedPose(now_, kTurnPerStep_rad_m * step_m_ * found->turn, shift);
  return Does::kMoved;
}

Nudge::Does Nudge::HandleKey(char byte) {
  if (escape_ == 1) {
    escape_ = byte == '[' ? 2 : 0;
    if (escape_ == 2) return Does::kNothing;
  } else if (escape_ == 2) {
    escape_ = 0;
    const auto end = std::find_if(std::begin(kSequences), std::end(kSequences),
                                  [byte](const SequenceEnd& row) { return row.byte == byte; });
    return end == std::end(kSequences) ? Does::kNothing : Act(end->key);
  }
  switch (byte) {
    case kEscape:
      escape_ = 1;
      return Does::kNothing;
    case 'q':
    case '\n':
    case '\r':
      return Does::kDone;
    case '+':
      step_m_ = std::min(kStepMax_m, step_m_ * 2);
      return Does::kNothing;
    case '-':
      step_m_ = std::max(kStepMin_m, step_m_ / 2);
      return Does::kNothing;
    case 'u':
      now_ = start_;
      return Does::kMoved;
    default:
      return Act(byte);
  }
}

}  // namespace omni::tools
