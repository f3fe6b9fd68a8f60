// Keeps the hand of omni try from pushing the pen through what it touches. A mouse has no force of its own to run out
// of: its aim would go on where a person feels that the base gives way. The aim stays so far beyond the surface that
// the hand's spring pulls with what the base can make there, and no more; nor so deep into what is soft that the pen
// would come out on its far side.
#pragma once

#include "service/protocol/hand_aim.h"
#include "service/protocol/state_memory.h"

namespace omni::monitor {

struct AimLimitOptions {
  double hand_stiffness_N_m = 0;  // > 0
  double force_max_N = 0;         // of the base, anywhere
};

class AimLimit {
 public:
  explicit AimLimit(const AimLimitOptions& options) : options_(options) {}

  // What is touched, and whether the base makes all of it. Called some ten times a second or more; `dt_s` > 0: since
  // the last call.
  void Feel(const protocol::ToolSample& tool, const protocol::ContactSnapshot& contacts, double dt_s);

  // The nearest aim that is allowed. The pen's axis stays.
  protocol::HandAim Limited(const protocol::HandAim& aim) const;

  // How far the aim may be beyond a surface; infinite while nothing is touched.
  double beyond_m() const;

 private:
  AimLimitOptions options_;
  protocol::ContactSnapshot contacts_;
  double beyond_m_ = 0;   // for what the base can make
  double soft_m_ = 0;     // for what gives way: with it the pen comes to rest at a depth
  double pressed_m_ = 0;  // for how fast it comes
  double away_s_ = 0;     // since anything was touched
  bool cut_ = false;      // the base could not make all since the contact began
};

}  // namespace omni::monitor
