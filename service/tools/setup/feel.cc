#include "service/tools/setup/setup.h"

#include <algorithm>
#include <chrono>
#include <optional>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/input_mapping.h"
#include "service/base/vec.h"
#include "service/config/files/device_file.h"
#include "service/monitor/trial/trial.h"
#include "service/tools/common/output.h"
#include "service/tools/common/service_link.h"
#include "service/tools/common/terminal.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

constexpr auto kLookPause = std::chrono::milliseconds(5);

// Why there may be no force: omnid's own words.
std::string ProblemsText() {
  const base::Result<nlohmann::json> status = FetchStatus("");
  if (!status.ok()) return status.error();
  std::string text;
  for (const nlohmann::json& problem : ArrayAt(*status, "/problems")) {
    if (problem.is_string()) text += (text.empty() ? "" : "; ") + problem.get<std::string>();
  }
  return text.empty()
             ? "is the tip within 10 cm of the base, and nothing else is magnetic nearby? `omni watch` shows it"
             : text;
}

void Look(const client::StateReader& state, Felt& felt, std::uint64_t& first_presses) {
  protocol::ToolSample sample;
  if (state.ReadNewest(sample)) {
    const auto& f = sample.force_base_N;
    felt.largest_force_N = std::max(felt.largest_force_N, base::Norm({f[0], f[1], f[2]}));
  }
  protocol::InputSnapshot inputs;
  if (!state.ReadInputs(inputs)) return;
  const std::uint64_t presses = inputs.components[static_cast<std::size_t>(base::InputComponent::kSelect)].press_count;
  if (first_presses == 0 || presses < first_presses) first_presses = presses + 1;
  felt.presses = static_cast<int>(presses + 1 - first_presses);
}

}  // namespace

base::Result<Felt> FeelScene(const SetupRun& run, const std::string& scene, double patience_s,
                             const std::function<bool(const Felt&)>& enough) {
  const EndSignals signals;
  const auto monitor = ConnectToService("");
  if (!monitor.ok()) return base::Error{monitor.error()};
  monitor::Trial trial({.socket_path = client::DefaultSocketPath(),
                        .hand_path = run.hand_socket(),
                        .folder = run.folder(),
                        .hull_radius_m = config::DefaultDevice().hull_radius_m});
  trial.ChooseScene(ShippedScene(scene), scene + ".glb", true);
  std::optional<ChildProgram> hand;
  if (run.rehearsal()) {
    base::Result<ChildProgram> started = run.OmniBehind({"twin", "hand", scene, "--hand", run.hand_socket(),
                                                         "--patience", std::to_string(static_cast<int>(patience_s))});
    if (!started.ok()) return base::Error{started.error()};
    hand = std::move(*started);
  }
  Felt felt;
  std::uint64_t first_presses = 0;
  const std::int64_t start_ns = base::MonotonicNow_ns();
  for (std::int64_t now_ns = start_ns; static_cast<double>(now_ns - start_ns) * 1e-9 < patience_s;
       now_ns = base::MonotonicNow_ns()) {
    if (EndSignals::asked()) return base::Error{"interrupted"};
    trial.Poll(now_ns);
    (*monitor)->Poll(now_ns);
    (*monitor)->SignalAlive();
    if (trial.scene().state == monitor::SceneState::kFailed) return base::Error{trial.scene().text};
    if (const auto state = (*monitor)->state()) Look(*state, felt, first_presses);
    const std::optional<int> ended = hand ? hand->Poll() : std::nullopt;
    if (ended ? *ended == 0 : !hand && enough(felt)) return felt;
    if (ended) break;  // the simulated hand has given up
    std::this_thread::sleep_for(kLookPause);
  }
  return base::Error{"the largest force was " + std::to_string(felt.largest_force_N).substr(0, 4) +
                     " N: " + ProblemsText()};
}

}  // namespace omni::tools
