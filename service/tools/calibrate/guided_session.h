// What a person does at a base step by step while its scans are read: scans go in, the currents asked for come out.
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
  virtual int step_number() const = 0;          // another one: the person has something else to do
  virtual double progress() const = 0;          // of this step, 0 to 1
  virtual std::string Instruction() const = 0;  // what to do in this step, one line
  virtual std::string Hint() const = 0;         // what holds this step up
};

}  // namespace omni::tools
