// Parts of `omni align`, from the guided session to the texts; `omni follow` uses some.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/alignment/dwell.h"
#include "service/alignment/fit.h"
#include "service/alignment/types.h"
#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/client/connection.h"
#include "service/config/files/device_file.h"

namespace omni::tools {

// The guided part of `omni align`: poses of a controller and the pen in, steps out, and at the end a base pose. Reads
// no clock and prints nothing, so that tests and benchmarks can run it in virtual time.

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

// The OpenXR half of `omni align` and `omni follow`: omni_align_probe (layer/examples/align) as a child, line by line.
enum class ProbeSays { kRuntime, kSystem, kSpace, kPose, kMotion, kLost, kMoved, kEnd };

struct ProbeLine {
  ProbeSays says = ProbeSays::kEnd;
  std::string text;       // kRuntime, kSystem: the name; kEnd: why; kPose: "left", "right_finger", ...
  int space = 0;          // kSpace: XrReferenceSpaceType
  std::int64_t t_ns = 0;  // kPose, kMotion: CLOCK_MONOTONIC
  alignment::Rigid pose;  // kPose, kMotion: X_LC
  bool moves = false;     // kMotion: its velocities are known
  base::Vec3 velocity_m_s, turn_rate_rad_s;
};

// Null: not a line of the probe (a runtime's library may print too).
std::optional<ProbeLine> ParseProbeLine(const std::string& line);

class AlignProbe {
 public:
  // Our own layer is disabled in the child: it must see the controller, not the pen in its place.
  static base::Result<std::unique_ptr<AlignProbe>> Start(const std::string& program,
                                                         const std::vector<std::string>& arguments);
  ~AlignProbe();  // ends the child
  AlignProbe(const AlignProbe&) = delete;
  AlignProbe& operator=(const AlignProbe&) = delete;

  // The next line, waited for `timeout_ms` at most. After the child has exited: always kEnd.
  std::optional<ProbeLine> NextLine(int timeout_ms);

 private:
  AlignProbe() = default;
  pid_t pid_ = -1;
  base::UniqueFd in_, out_;  // the child's standard input (it runs while this is open) and standard output
  std::string buffer_;
  bool ended_ = false;
};

// Beside this program.
std::string DefaultProbe();

// Requests of `omni align` to omnid.

// Waits for the answer, 2.5 s at most. A refusal is an error with omnid's text; otherwise the result is that text.
base::Result<std::string> RequestBasePose(client::Connection& connection, const protocol::BasePoseCommand& command);

struct Headset {
  std::string runtime, system;
  int space = protocol::kSpaceLocal;
};

protocol::BasePoseCommand StoreCommand(const Headset& headset, const alignment::Outcome& outcome,
                                       const std::string& method);

// One of the stored alignments by its number in `omni align --show`.
struct StoredAlignment {
  Headset headset;
  alignment::Rigid base_space;
  int samples = 0;
  double rms_m = 0;
};
// Of this headset in this space.
base::Result<StoredAlignment> AlignmentOf(const nlohmann::json& status, const Headset& headset);
// The stored base pose moved so that its mark is where it was touched; its orientation is kept.
alignment::Rigid BaseAsTouched(const alignment::Rigid& stored, const base::Vec3& mark_base_m,
                               const base::Vec3& touched_space_m);
// `number` 0: the one of a connected application's headset, else the only one. Without any: the headset of a connected
// application, its base where the layer guesses it.
base::Result<StoredAlignment> ChooseAlignment(const nlohmann::json& status, int number);

// `omni align` with a person in front of it: the probe's poses and the pen's into a session, its steps onto the
// terminal.
struct AlignRunOptions {
  AlignOptions session;
  std::string hand = "auto";  // left, right; auto: whichever moves first
  std::string probe;
  double patience_s = 120;  // gives up after this time
};

struct Aligned {
  Headset headset;
  alignment::Outcome outcome;
  base::Vec3 mark_space_m;  // of AlignMethod::kCheck
};

// Prints steps and progress. Ends with a base pose, a refusal, the end of patience or of the runtime's session, or a
// signal.
base::Result<Aligned> RunAlignment(client::Connection& connection, const AlignRunOptions& options);

// `omni align nudge`: keys shift and turn the stored base pose while an application shows the pen.

// The base pose as changed by the keys so far.
class Nudge {
 public:
  explicit Nudge(const alignment::Rigid& start) : start_(start), now_(start) {}
  enum class Does { kNothing, kMoved, kDone };
  // Bytes of a terminal: arrows and Page Up/Down in their usual sequences, and letters.
  Does HandleKey(char byte);
  const alignment::Rigid& base_pose() const { return now_; }
  double step_m() const { return step_m_; }

 private:
  Does Act(char action);
  alignment::Rigid start_, now_;
  double step_m_ = 5e-3;
  int escape_ = 0;  // bytes of a sequence seen so far
};

// Texts of `omni align`.

// Instruction for the current step, one line.
std::string AlignStepText(const AlignSession& session);
// The base pose and its accuracy.
std::string AlignOutcomeText(const AlignOptions& options, const alignment::Outcome& outcome);
// "excellent", "good", "fair" or "poor", by the expected error.
std::string AlignQualityWord(double expected_error_m);
// STAGE, LOCAL_FLOOR, LOCAL, or the number.
std::string SpaceName(int space);
// "N  runtime / system in SPACE: ..." one line each, from /alignments of a status.
std::string StoredAlignmentsText(const nlohmann::json& status);

}  // namespace omni::tools
