// omni align: measures where the base is in a headset's space; omnid stores the result.
#include "service/tools/align/align.h"

#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/protocol/text.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"

namespace omni::tools {
namespace {

constexpr const char* kAlign = "omni align";
constexpr const char* kMethods[] = {"touch", "sweep", "fingertip", "nudge"};
constexpr double kFair_m = 4e-3;
constexpr const char* kPolicies[] = {"front-of-user", "calibrated", "off"};

struct AlignArguments {
  std::string method = "touch";
  std::string socket, marks, policy;
  bool as_json = false, show = false, forget = false, restore = false, tilted = false;
  bool check = false, correct = false;
  int number = 0;
  AlignRunOptions run;
};

// While it exists, keys arrive one by one and are not echoed.
class RawKeys {
 public:
  RawKeys() : terminal_(::tcgetattr(STDIN_FILENO, &before_) == 0) {
    termios raw = before_;
    raw.c_lflag &= static_cast<tcflag_t>(~(ICANON | ECHO));
    if (terminal_) ::tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  }
  ~RawKeys() {
    if (terminal_) ::tcsetattr(STDIN_FILENO, TCSANOW, &before_);
  }
  RawKeys(const RawKeys&) = delete;
  RawKeys& operator=(const RawKeys&) = delete;

 private:
  termios before_{};
  bool terminal_;
};

int NudgeStored(client::Connection& connection, const nlohmann::json& status, int number) {
  const auto chosen = ChooseAlignment(status, number);
  if (!chosen.ok()) return Fail(kAlign, chosen.error());
  std::printf("headset      %s / %s, in its %s space\n", chosen->headset.runtime.c_str(),
              chosen->headset.system.c_str(), SpaceName(chosen->headset.space).c_str());
  Print("arrows: left, right, away, near; Page Up/Down: up, down; [ ]: turn; + -: step; u: undo all; q: done\n");
  Nudge nudge(chosen->base_space);
  const RawKeys keys;
  for (char byte = 0; ::read(STDIN_FILENO, &byte, 1) == 1;) {
    const Nudge::Does does = nudge.HandleKey(byte);
    if (does == Nudge::Does::kDone) break;
    if (does == Nudge::Does::kNothing) continue;
    alignment::Outcome outcome;
    outcome.base_space = nudge.base_pose();
    outcome.samples = chosen->samples;
    outcome.rms_m = chosen->rms_m;
    connection.Poll(base::MonotonicNow_ns());
    const auto stored = RequestBasePose(connection, StoreCommand(chosen->headset, outcome, "nudge"));
    if (!stored.ok()) return Fail(kAlign, stored.error());
    std::printf("moved        %.1f mm and %.1f deg from where it was\n",
                1e3 * alignment::Distance_m(nudge.base_pose(), chosen->base_space, {}),
                57.29577951308232 * alignment::Angle_rad(nudge.base_pose(), chosen->base_space));
    std::fflush(stdout);
  }
  return kExitOk;
}

int ForgetStored(client::Connection& connection, const nlohmann::json& status, int number) {
  protocol::BasePoseCommand command;
  command.action = protocol::BasePoseAction::kForget;
  if (number > 0) {
    const auto chosen = ChooseAlignment(status, number);
    if (!chosen.ok()) return Fail(kAlign, chosen.error());
    command = StoreCommand(chosen->headset, {}, "");
    command.action = protocol::BasePoseAction::kForget;
  }
  const auto done = RequestBasePose(connection, command);
  if (!done.ok()) return Fail(kAlign, done.error());
  Print(*done + "\n");
  return kExitOk;
}

int RestoreStored(client::Connection& connection, const nlohmann::json& status, int number) {
  const auto chosen = ChooseAlignment(status, number);
  if (!chosen.ok()) return Fail(kAlign, chosen.error());
  protocol::BasePoseCommand command = StoreCommand(chosen->headset, {}, "");
  command.action = protocol::BasePoseAction::kRestore;
  const auto done = RequestBasePose(connection, command);
  if (!done.ok()) return Fail(kAlign, done.error());
  std::printf("%s\n", done->c_str());
  return kExitOk;
}

int SetPolicy(client::Connection& connection, const std::string& policy) {
  protocol::BasePoseCommand command;
  command.action = protocol::BasePoseAction::kPolicy;
  for (std::size_t i = 0; i < std::size(kPolicies); ++i) {
    if (policy == kPolicies[i]) command.uncalibrated = static_cast<protocol::Uncalibrated>(i);
  }
  const auto done = RequestBasePose(connection, command);
  if (!done.ok()) return Fail(kAlign, done.error());
  Print(*done + "\n");
  return kExitOk;
}

base::Status UseMarks(AlignArguments& arguments) {
  if (arguments.marks.empty()) return base::Ok{};
  auto marks = config::LoadMarksFile(arguments.marks);
  if (!marks.ok()) return base::Error{marks.error()};
  arguments.run.session.marks = std::move(*marks);
  return base::Ok{};
}

int Measure(client::Connection& connection, AlignArguments arguments) {
  arguments.run.session.level = !arguments.tilted;
  for (const AlignMethod method : {AlignMethod::kTouch, AlignMethod::kSweep, AlignMethod::kFingertip}) {
    if (arguments.method == AlignMethodName(method)) arguments.run.session.method = method;
  }
  if (const auto given = UseMarks(arguments); !given.ok()) return Fail(kAlign, given.error());
  const auto aligned = RunAlignment(connection, arguments.run);
  if (!aligned.ok()) return Fail(kAlign, aligned.error());
  Print(AlignOutcomeText(arguments.run.session, aligned->outcome));
  const auto stored = RequestBasePose(connection, StoreCommand(aligned->headset, aligned->outcome, arguments.method));
  if (!stored.ok()) return Fail(kAlign, stored.error());
  std::printf("stored       %s; running applications use it already\n", stored->c_str());
  return kExitOk;
}

// One touch of the first mark: how far off is what is stored?
int CheckStored(client::Connection& connection, const nlohmann::json& status, AlignArguments arguments) {
  arguments.run.session.method = AlignMethod::kCheck;
  if (const auto given = UseMarks(arguments); !given.ok()) return Fail(kAlign, given.error());
  const auto aligned = RunAlignment(connection, arguments.run);
  if (!aligned.ok()) return Fail(kAlign, aligned.error());
  const auto stored = AlignmentOf(status, aligned->headset);
  if (!stored.ok()) return Fail(kAlign, stored.error());
  alignment::Outcome outcome;
  outcome.base_space =
      BaseAsTouched(stored->base_space, arguments.run.session.marks[0].position_base_m, aligned->mark_space_m);
  protocol::BasePoseCommand command = StoreCommand(aligned->headset, outcome, "check");
  command.action = protocol::BasePoseAction::kCheck;
  command.correct = arguments.correct ? 1 : 0;
  const auto done = RequestBasePose(connection, command);
  if (!done.ok()) return Fail(kAlign, done.error());
  std::printf("mark %s       %s\n", arguments.run.session.marks[0].name.c_str(), done->c_str());
  const double offset_m = base::Distance(outcome.base_space.position_m, stored->base_space.position_m);
  if (!arguments.correct && offset_m > kFair_m) {
    Print("             to move it there: omni align --check --correct; to measure its turn too: omni align\n");
  }
  return kExitOk;
}

int Align(const AlignArguments& arguments) {
  auto connection = ConnectToService(arguments.socket, protocol::ClientRole::kTool);
  if (!connection.ok()) return FailWith(arguments.as_json, kAlign, connection.error(), kExitNoService);
  if (!arguments.policy.empty()) return SetPolicy(**connection, arguments.policy);
  const bool stored =
      arguments.check || arguments.show || arguments.forget || arguments.restore || arguments.method == "nudge";
  if (!stored) return Measure(**connection, arguments);
  const auto status = RequestStatus(**connection);
  if (!status.ok()) return FailWith(arguments.as_json, kAlign, status.error());
  if (arguments.check) return CheckStored(**connection, *status, arguments);
  if (arguments.forget) return ForgetStored(**connection, *status, arguments.number);
  if (arguments.restore) return RestoreStored(**connection, *status, arguments.number);
  if (!arguments.show) return NudgeStored(**connection, *status, arguments.number);
  if (arguments.as_json) {
    PrintJson(status->value("alignments", nlohmann::json::object()));
  } else {
    Print(StoredAlignmentsText(*status));
  }
  return kExitOk;
}

}  // namespace

void AddAlign(Command& app) {
  auto arguments = std::make_shared<AlignArguments>();
  Command align = app.AddCommand("align", "measure where the base is in a headset's space; omnid stores it");
  align
      .Add("method", arguments->method,
           "touch: touch marks on the base with a controller; sweep: move pen and controller together; fingertip: "
           "touch the pen's tip with an index finger; nudge: adjust by keys")
      .OneOf({std::begin(kMethods), std::end(kMethods)})
      .ShowDefault();
  const console::Option show = align.Add("--show", arguments->show, "list the stored alignments");
  align.Add("--json", arguments->as_json, "--show: as JSON").Needs(show);
  align.Add("--forget", arguments->forget, "delete the stored alignments, or only --number N");
  const console::Option check =
      align.Add("--check", arguments->check, "touch mark 1: how far is the stored alignment off? Takes some seconds");
  align.Add("--correct", arguments->correct, "--check: move the stored alignment to where it was touched").Needs(check);
  align.Add("--restore", arguments->restore, "restore an alignment as measured, before any recentring");
  align
      .Add("--placement", arguments->policy,
           "what the pen does without an alignment: front-of-user (a guess), calibrated (no pose), off")
      .OneOf({std::begin(kPolicies), std::end(kPolicies)});
  align.Add("--number", arguments->number, "as in --show; for nudge, --forget and --restore").Range(1, 64);
  align.Add("--hand", arguments->run.hand, "which controller").OneOf({"auto", "left", "right"}).ShowDefault();
  align.Add("--tilted", arguments->tilted, "the base is not level");
  align.Add("--marks", arguments->marks, "file of marks (default: the built-in marks.toml)");
  align.Add("--places", arguments->run.session.fingertips, "fingertip: how many places to touch")
      .Range(4, 20)
      .ShowDefault();
  align.Add("--patience", arguments->run.patience_s, "give up after this many seconds")
      .Range(5.0, 3600.0)
      .ShowDefault();
  align.Add("--probe", arguments->run.probe,
            "the program that reads poses from the OpenXR runtime (default: omni_align_probe)");
  AddSocket(align, arguments->socket);
  align.SetAction(arguments, Align);
}

}  // namespace omni::tools
