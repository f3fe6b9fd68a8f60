// Guides a person through steps at a base: consumes its scans and returns the currents to set.
#pragma once

#include <string>

#include "service/base/actuation_types.h"
#include "service/base/hall_scan.h"

namespace omni::tools {

class GuidedSession {
 public:
  virtual ~GuidedSession() = default;

  // Every scan in turn; returns the currents to set next.
  virtual base::CoilCurrents Add(const base::HallScan& scan) = 0;

  virtual bool done() const = 0;
  virtual int step_number() const = 0;          // changes when the instruction changes
  virtual double progress() const = 0;          // of this step, 0 to 1
  virtual std::string Instruction() const = 0;  // what to do in this step, one line
  virtual std::string Hint() const = 0;         // what holds this step up
};

}  // namespace omni::tools
