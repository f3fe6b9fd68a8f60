// `omni align nudge`: keys shift and turn the stored placement while an application shows the pen.
#pragma once

#include <optional>

#include "service/alignment/types.h"

namespace omni::tools {

// The placement as changed by the keys so far.
class Nudge {
 public:
  explicit Nudge(const alignment::Rigid& start) : start_(start), now_(start) {}
  enum class Does { kNothing, kMoved, kDone };
  // Bytes of a terminal: arrows and Page Up/Down in their usual sequences, and letters.
  Does Key(char byte);
  const alignment::Rigid& placement() const { return now_; }
  double step_m() const { return step_m_; }

 private:
  Does Act(char action);
  alignment::Rigid start_, now_;
  double step_m_ = 5e-3;
  int escape_ = 0;  // bytes of a sequence seen so far
};

}  // namespace omni::tools
