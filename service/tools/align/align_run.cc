#include "service/tools/align/align.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <deque>
#include <map>
#include <utility>

#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/console/wrap.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

constexpr int kAlignBarWidth = 24;
constexpr std::int64_t kPenDelay_ns = 30'000'000;  // a pose waits this long for the pen's samples around it
constexpr std::int64_t kPenGap_ns = 20'000'000;    // samples further apart: the pen was not tracked between them
constexpr double kMoved_m = 0.03;                  // the first hand to move this far is used
constexpr std::size_t kMaxWaiting = 4096;

std::optional<PenSeen> PenAtTime(const client::StateReader& reader, std::int64_t t_ns) {
  protocol::ToolSample before, after;
  if (!reader.ReadAround(t_ns, before, after)) return std::nullopt;
  const bool tracked = (before.flags & after.flags & protocol::kToolTracked) != 0;
  if (!tracked || after.t_ns - before.t_ns > kPenGap_ns || t_ns - before.t_ns > kPenGap_ns || t_ns < before.t_ns) {
    return std::nullopt;
  }
  const double u = after.t_ns > before.t_ns
                       ? static_cast<double>(t_ns - before.t_ns) / static_cast<double>(after.t_ns - before.t_ns)
                       : 0.0;
  const auto mix = [u](const std::array<double, 3>& a, const std::array<double, 3>& b) {
    return base::Vec3{a[0] + u * (b[0] - a[0]), a[1] + u * (b[1] - a[1]), a[2] + u * (b[2] - a[2])};
  };
  return PenSeen{.position_base_m = mix(before.position_base_m, after.position_base_m),
                 .velocity_base_m_s = mix(before.linear_velocity_base_m_s, after.linear_velocity_base_m_s)};
}

// On a terminal one line that is updated, otherwise one line per step.
class AlignDisplay {
 public:
  void Show(const AlignSession& session) {
    const std::string text = AlignStepText(session);
    if (text != text_) {
      if (live_ && !text_.empty()) std::printf("\r\033[K");
      Print(text + "\n");
      std::fflush(stdout);
      text_ = text;
      line_.clear();
      left_ = {};
    }
    if (!live_ || session.step() == AlignStep::kDone) return;
    const std::string line =
        ProgressBar(session.progress(), kAlignBarWidth) + left_.Text(session.progress()) + "  " + session.hint();
    if (line == line_) return;
    line_ = line;
    std::printf("\r\033[K     %.*s", std::max(0, console::SizeOfTerminal().columns - 6), line.c_str());
    std::fflush(stdout);
  }
  void Say(const std::string& text) {
    if (live_) std::printf("\r\033[K");
    Print(text + "\n");
    std::fflush(stdout);
    line_.clear();
  }

 private:
  bool live_ = CanDraw();
  std::string text_, line_;
  TimeLeft left_;
};

// Selects the hand or finger among the probe's poses.
class HandChoice {
 public:
  HandChoice(const std::string& hand, bool fingers) : suffix_(fingers ? "_finger" : "") {
    if (hand != "auto") chosen_ = hand + suffix_;
  }
  bool Is(const ProbeLine& line) {
    if (!chosen_.empty()) return line.text == chosen_;
    const bool finger = line.text.find("_finger") != std::string::npos;
    if (finger == suffix_.empty()) return false;
    const auto [first, fresh] = first_.emplace(line.text, line.pose);
    if (!fresh && alignment::Distance_m(first->second, line.pose, {}) > kMoved_m) chosen_ = line.text;
    return !chosen_.empty();
  }

 private:
  std::string suffix_, chosen_;
  std::map<std::string, alignment::Rigid> first_;
};

// Poses wait until the pen's samples of their time are there.
void Feed(client::Connection& connection, std::deque<ProbeLine>& waiting, AlignSession& session) {
  const std::int64_t now_ns = base::MonotonicNow_ns();
  while (!waiting.empty() && (waiting.front().t_ns + kPenDelay_ns <= now_ns || waiting.size() > kMaxWaiting)) {
    const ProbeLine& line = waiting.front();
    std::optional<PenSeen> pen;
    if (const auto reader = connection.state()) pen = PenAtTime(*reader, line.t_ns);
    session.Add(1e-9 * static_cast<double>(line.t_ns), line.pose, pen);
    waiting.pop_front();
  }
}

}  // namespace

base::Result<Aligned> RunAlignment(client::Connection& connection, const AlignRunOptions& options) {
  const bool fingers = options.session.method == AlignMethod::kFingertip;
  auto probe = AlignProbe::Start(options.probe.empty() ? DefaultProbe() : options.probe,
                                 fingers ? std::vector<std::string>{"--fingers"} : std::vector<std::string>{});
  if (!probe.ok()) return base::Error{probe.error()};
  const EndSignals signals;
  AlignSession session(options.session);
  AlignDisplay display;
  HandChoice hand(options.hand, fingers);
  Aligned aligned;
  std::deque<ProbeLine> waiting;
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(options.patience_s * 1e9);
  while (!EndSignals::asked()) {
    connection.Poll(base::MonotonicNow_ns());
    const std::optional<ProbeLine> line = (*probe)->NextLine(10);
    if (line && line->says == ProbeSays::kEnd) return base::Error{"the OpenXR session ended: " + line->text};
    if (line && line->says == ProbeSays::kRuntime) aligned.headset.runtime = line->text;
    if (line && line->says == ProbeSays::kSystem) aligned.headset.system = line->text;
    if (line && line->says == ProbeSays::kSpace) {
      aligned.headset.space = line->space;
      display.Say("headset      " + aligned.headset.runtime + " / " + aligned.headset.system + ", in its " +
                  SpaceName(line->space) + " space");
      display.Show(session);
    }
    if (line && line->says == ProbeSays::kMoved) {
      display.Say("the headset was recentred: starting over");
      waiting.clear();
      session.Restart();
    }
    if (line && line->says == ProbeSays::kPose && hand.Is(*line)) waiting.push_back(*line);
    Feed(connection, waiting, session);
    if (line && line->says != ProbeSays::kRuntime && line->says != ProbeSays::kSystem) display.Show(session);
    if (session.step() == AlignStep::kRefused) return base::Error{session.problem()};
    if (session.step() == AlignStep::kDone) {
      aligned.outcome = session.outcome();
      aligned.mark_space_m = session.mark_space_m();
      return aligned;
    }
    if (base::MonotonicNow_ns() > deadline_ns) {
      return base::Error{
          "no alignment within " + std::to_string(static_cast<int>(options.patience_s)) + " s" +
          (session.hint().empty() ? "; is the controller switched on and tracked?" : ": " + session.hint())};
    }
  }
  return base::Error{"interrupted; nothing was stored"};
}

}  // namespace omni::tools
