#include "service/tools/calibrate/calibrate_session.h"

#include <string>

#include "firmware/wire/messages.h"
#include "service/base/clock.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

constexpr std::int64_t kSilence_ns = 1'000'000'000;
constexpr double kArming_s = 5;
constexpr double kPatience_s = 120;

// The session waits for a base that has reported its coils as off.
bool IsArming(const device::TransportState& base) {
  const auto state = static_cast<wire::State>(base.state);
  return state == wire::State::kSelfTest || state == wire::State::kIdle || state == wire::State::kFault;
}

// When the session last made progress.
class Progress {
 public:
  // Seconds since.
  double Waited_s(const GuidedSession& session, std::int64_t t_ns) {
    if (t_ns_ == 0 || session.step_number() != step_ || session.progress() > reached_) {
      step_ = session.step_number();
      reached_ = session.progress();
      t_ns_ = t_ns;
    }
    return base::Elapsed_s(t_ns, t_ns_);
  }

 private:
  int step_ = 0;
  double reached_ = 0;
  std::int64_t t_ns_ = 0;
};

std::string ReadProblem(device::ReadStatus status, const GuidedSession& session) {
  switch (status) {
    case device::ReadStatus::kScan:
      return {};
    case device::ReadStatus::kTimeout:
      return "the base sends nothing: unplug it, wait a second, plug it in and start again";
    case device::ReadStatus::kGone:
      return "the base was disconnected: check its cable and start again";
    case device::ReadStatus::kEnd:
      break;
  }
  return "the recording ended before this step was done: " + session.Instruction();
}

std::string StateProblem(const device::TransportState& state, double arming_s) {
  if (state.waits_for_person) return "the base is in a fault and keeps its coils off: omni device selftest shows which";
  if (IsArming(state) && arming_s > kArming_s) return "the base does not switch its coils on: run omni device selftest";
  return {};
}

}  // namespace

base::Status RunSession(device::Transport& transport, GuidedSession& session, const std::function<void()>& observer) {
  Progress progress;
  std::string problem;
  base::HallScan scan;
  std::int64_t first_ns = 0;
  while (problem.empty() && !session.done()) {
    problem = EndSignals::asked() ? "interrupted; nothing was written"
                                  : ReadProblem(transport.Read(scan, kSilence_ns), session);
    if (!problem.empty()) break;
    if (first_ns == 0) first_ns = scan.t_ns;
    const device::TransportState state = transport.state();
    problem = StateProblem(state, base::Elapsed_s(scan.t_ns, first_ns));
    if (IsArming(state)) {
      transport.Write({});
      continue;
    }
    transport.Write(session.Add(scan));
    if (observer) observer();
    if (progress.Waited_s(session, scan.t_ns) > kPatience_s) {
      problem = "two minutes without progress in step " + session.Instruction() + " " + session.Hint();
    }
  }
  transport.Write({});
  if (!problem.empty()) return base::Error{problem};
  return base::Ok{};
}

}  // namespace omni::tools
