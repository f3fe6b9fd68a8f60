#include "service/tools/align/align.h"

#include <chrono>
#include <cmath>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/alignment/rigid.h"
#include "service/base/clock.h"
#include "service/config/runtime_identity.h"
#include "service/protocol/text.h"
#include "service/tools/common/output.h"

namespace omni::tools {
namespace {

constexpr std::int64_t kAnswer_ns = 2'500'000'000;

StoredAlignment ReadStored(const nlohmann::json& row) {
  StoredAlignment stored;
  stored.headset = {.runtime = TextAt(row, "/runtime"),
                    .system = TextAt(row, "/system"),
                    .space = static_cast<int>(NumberAt(row, "/space"))};
  stored.base_space.position_m = {NumberAt(row, "/position_space_m/0"), NumberAt(row, "/position_space_m/1"),
                                  NumberAt(row, "/position_space_m/2")};
  stored.base_space.orientation = {
      NumberAt(row, "/orientation_space_wxyz/0"), NumberAt(row, "/orientation_space_wxyz/1"),
      NumberAt(row, "/orientation_space_wxyz/2"), NumberAt(row, "/orientation_space_wxyz/3")};
  stored.samples = static_cast<int>(NumberAt(row, "/samples"));
  stored.rms_m = 1e-3 * NumberAt(row, "/rms_mm");
  return stored;
}

bool SameHeadset(const nlohmann::json& row, const nlohmann::json& client) {
  return TextAt(row, "/system") == TextAt(client, "/system") &&
         config::RuntimeIdentity(TextAt(row, "/runtime")) == config::RuntimeIdentity(TextAt(client, "/runtime"));
}

// The client whose headset is known, if any.
const nlohmann::json* PlacedClient(const nlohmann::json& status) {
  for (const nlohmann::json& client : ArrayAt(status, "/clients")) {
    const std::string runtime = TextAt(client, "/runtime");
    if (runtime != "-" && !runtime.empty()) return &client;
  }
  return nullptr;
}

}  // namespace

base::Result<std::string> RequestBasePose(client::Connection& connection, const protocol::BasePoseCommand& command) {
  const std::uint32_t number = connection.SendBasePoseCommand(command);
  if (number == 0) return base::Error{"omnid does not accept requests; restart omnid"};
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + kAnswer_ns;
  while (base::MonotonicNow_ns() < deadline_ns) {
    connection.Poll(base::MonotonicNow_ns());
    const std::optional<client::BasePoseAnswer> answer = connection.PopBasePoseAnswer();
    if (answer && answer->number == number) {
      if (!answer->done) return base::Error{answer->text};
      return answer->text;
    }
    if (!connection.connected()) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return base::Error{"omnid did not answer within 2.5 s (" + connection.last_error() + "); restart omnid"};
}

protocol::BasePoseCommand StoreCommand(const Headset& headset, const alignment::Outcome& outcome,
                                       const std::string& method) {
  protocol::BasePoseCommand command;
  command.action = protocol::BasePoseAction::kStore;
  protocol::SetField(command.headset.runtime, headset.runtime);
  protocol::SetField(command.headset.system, headset.system);
  command.space = headset.space;
  const base::Vec3& p = outcome.base_space.position_m;
  const base::Quat& q = outcome.base_space.orientation;
  command.base_space = {.position_m = {p.x, p.y, p.z}, .orientation_wxyz = {q.w, q.x, q.y, q.z}};
  command.rms_m = outcome.rms_m;
  command.expected_error_m = outcome.expected_error_m;
  command.rotation_sigma_rad = outcome.rotation_sigma_rad;
  command.samples = static_cast<std::uint32_t>(outcome.samples);
  protocol::SetField(command.method, method);
  return command;
}

base::Result<StoredAlignment> AlignmentOf(const nlohmann::json& status, const Headset& headset) {
  const nlohmann::json named{{"runtime", headset.runtime}, {"system", headset.system}};
  for (const nlohmann::json& row : ArrayAt(status, "/alignments/stored")) {
    if (SameHeadset(row, named) && NumberAt(row, "/space") == headset.space) return ReadStored(row);
  }
  return base::Error{"no alignment is stored for this headset in this space; measure one: omni align"};
}

alignment::Rigid BaseAsTouched(const alignment::Rigid& stored, const base::Vec3& mark_base_m,
                               const base::Vec3& touched_space_m) {
  alignment::Rigid moved = stored;
  moved.position_m = stored.position_m + (touched_space_m - alignment::TransformPoint(stored, mark_base_m));
  return moved;
}

base::Result<StoredAlignment> ChooseAlignment(const nlohmann::json& status, int number) {
  const nlohmann::json& rows = ArrayAt(status, "/alignments/stored");
  if (number > static_cast<int>(rows.size())) {
    return base::Error{"there is no alignment " + std::to_string(number) + "; see omni align --show"};
  }
  if (number > 0) return ReadStored(rows[static_cast<std::size_t>(number - 1)]);
  const nlohmann::json* client = PlacedClient(status);
  for (const nlohmann::json& row : rows) {
    if (client != nullptr && SameHeadset(row, *client)) return ReadStored(row);
  }
  if (client == nullptr && rows.size() == 1) return ReadStored(rows[0]);
  if (client == nullptr) {
    return base::Error{rows.empty() ? "no alignment is stored and no application runs; measure one: omni align"
                                    : "several alignments are stored: name one with --number N, see omni align --show"};
  }
  StoredAlignment guess;
  guess.headset = {.runtime = TextAt(*client, "/runtime"), .system = TextAt(*client, "/system")};
  guess.base_space = alignment::LevelBase();
  guess.base_space.position_m = {0, -0.35, -0.45};  // as the layer guesses it
  return guess;
}

}  // namespace omni::tools
