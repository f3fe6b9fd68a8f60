// The guided part of `omni align`: poses of a controller and the pen in, steps out, and at the end a placement. Reads
// no clock and prints nothing, so that tests and benchmarks can run it in virtual time.
#pragma once

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "service/alignment/dwell.h"
#include "service/alignment/fit.h"
#include "service/alignment/pivot.h"
#include "service/config/files/marks_file.h"

namespace omni::tools {

// kCheck: one touch, of the first mark; nothing is measured but that point.
enum class AlignMethod { kTouch, kSweep, kFingertip, kCheck };
// "touch", "sweep", "fingertip", "check"
const char* AlignMethodName(AlignMethod method);

struct AlignOptions {
  AlignMethod method = AlignMethod::kTouch;
  std::vector<config::Mark> marks = config::DefaultMarks();  // touch
  bool level = true;                                         // the base is level
  int fingertips = 5;                                        // places to touch
  double sweep_s_max = 25;
};

struct PenSeen {
  base::Vec3 position_base_m;  // tip
  base::Vec3 velocity_base_m_s;
};

enum class AlignStep { kPivot, kTouch, kSweep, kFingertip, kDone, kRefused };

class AlignSession {
 public:
  explicit AlignSession(AlignOptions options);

  // The controller's grip (fingertip: the finger's joint) at that time, and the pen where it is tracked. Times grow.
  void Add(double t_s, const alignment::Rigid& controller_space, const std::optional<PenSeen>& pen);
  // The space was moved: discards all measurements.
  void Restart();

  AlignStep step() const { return step_; }
  int touched() const { return touched_; }           // marks or places that are done
  double progress() const;                           // of this step, 0 to 1
  const std::string& hint() const { return hint_; }  // what is still missing; empty: nothing
  // After kDone.
  const alignment::Outcome& outcome() const { return outcome_; }
  // After kDone of kCheck: where the first mark is.
  const base::Vec3& mark_space_m() const { return pivot_.centre_space_m; }
  // After kRefused: why, and what to do.
  const std::string& problem() const { return problem_; }
  const AlignOptions& options() const { return options_; }

 private:
  struct Posed {
    double t_s;
    alignment::Rigid pose;
    std::optional<PenSeen> pen;
  };
  void AddPivot();
  void AddTouch();
  void AddSweep();
  void AddFingertip();
  // What the dwell of the last half second saw.
  std::vector<Posed> Dwelt() const;
  void Finish(base::Result<alignment::Outcome> outcome);

  AlignOptions options_;
  AlignStep step_ = AlignStep::kPivot;
  std::deque<Posed> recent_;
  alignment::DwellDetector dwell_;
  alignment::Pivot pivot_;
  std::vector<alignment::Sample> samples_;
  double next_try_s_ = 0;
  double start_s_ = 0;
  bool started_ = false;
  int touched_ = 0;
  double quality_ = 0;  // progress of pivot and sweep
  std::string hint_;
  alignment::Outcome outcome_;
  std::string problem_;
};

// Prior and acceptance limits of each method; used by the session and by its tests and benchmarks.
alignment::Prior PriorOf(AlignMethod method, bool level);
alignment::Limits LimitsOf(AlignMethod method);

}  // namespace omni::tools
