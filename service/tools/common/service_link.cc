#include "service/tools/common/service_link.h"

#include <chrono>
#include <thread>

#include <nlohmann/json.hpp>

#include "service/base/clock.h"
#include "service/base/files/json_document.h"

namespace omni::tools {
namespace {

constexpr std::int64_t kPatience_ns = 2'500'000'000;  // longer than the connection's own wait for a welcome
constexpr std::int64_t kScenePatience_ns = 30'000'000'000;
constexpr auto kPause = std::chrono::milliseconds(2);
constexpr std::int64_t kStale_ns = 100'000'000;  // an older sample is not "now"

base::Error NotRunning(const std::string& path, const std::string& why) {
  const bool named = why.find(path) != std::string::npos;
  return {(named ? why : "omnid does not answer at " + path + (why.empty() ? "" : " (" + why + ")")) +
          "; to start it: `omnid --device twin` or `systemctl --user start omnid`"};
}

}  // namespace

base::Result<std::unique_ptr<client::Connection>> ConnectToService(const std::string& socket_path,
                                                                   protocol::ClientRole role) {
  const std::string path = socket_path.empty() ? client::DefaultSocketPath() : socket_path;
  auto connection = std::make_unique<client::Connection>(
      client::ConnectionInfo{.role = role, .application = "omni", .engine = "", .socket_path = path});
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + kPatience_ns;
  while (base::MonotonicNow_ns() < deadline_ns) {
    connection->Poll(base::MonotonicNow_ns());
    if (connection->connected()) return connection;
    if (!connection->last_error().empty()) break;  // the attempt is over: no point in waiting for the next
    std::this_thread::sleep_for(kPause);
  }
  return NotRunning(path, connection->last_error());
}

base::Result<nlohmann::json> RequestStatus(client::Connection& connection) {
  if (!connection.Send(protocol::StatusRequest{})) return base::Error{"omnid does not accept requests; restart omnid"};
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + kPatience_ns;
  while (base::MonotonicNow_ns() < deadline_ns) {
    connection.Poll(base::MonotonicNow_ns());
    if (const std::string text = connection.PopStatus(); !text.empty()) {
      nlohmann::json status = base::ParseJsonOrNull(text);
      if (status.is_object()) return status;
      return base::Error{"omnid's status is not a JSON object; install the same Omni version for both"};
    }
    if (!connection.connected()) break;
    std::this_thread::sleep_for(kPause);
  }
  return base::Error{"omnid did not answer within 2.5 s (" + connection.last_error() + "); restart omnid"};
}

base::Result<client::SceneAnswer> RequestScene(client::Connection& connection, protocol::SceneAction action,
                                               std::uint64_t client_id, const std::string& object) {
  const std::uint32_t number = connection.SendSceneCommand(action, client_id, object);
  if (number == 0) return base::Error{"omnid does not accept requests; restart omnid"};
  const std::int64_t deadline_ns = base::MonotonicNow_ns() + kScenePatience_ns;
  while (base::MonotonicNow_ns() < deadline_ns) {
    connection.Poll(base::MonotonicNow_ns());
    std::optional<client::SceneAnswer> answer = connection.PopSceneAnswer();
    if (answer && answer->number == number) return std::move(*answer);
    if (!connection.connected()) break;
    std::this_thread::sleep_for(kPause);
  }
  return base::Error{"omnid did not answer within 30 s (" + connection.last_error() + "); restart omnid"};
}

void AddNewestSample(const protocol::ToolSample& sample, std::int64_t now_ns, nlohmann::json& status) {
  const bool fresh = now_ns - sample.t_ns < kStale_ns;
  const bool tracked = (sample.flags & protocol::kToolTracked) != 0;
  const bool known = (sample.flags & protocol::kToolPoseValid) != 0;
  if (!status.contains("tracking")) {
    nlohmann::json& tracking = status["tracking"];
    tracking["status"] = !known ? "absent" : tracked && fresh ? "tracking" : "lost";
    tracking["position_m"] = sample.position_base_m;
    tracking["gap_m"] = sample.gap_m;
    tracking["sigma_mm"] = sample.position_sigma_m * 1e3;
    tracking["age_ms"] = static_cast<double>(now_ns - sample.t_ns) * 1e-6;
  }
  if (!status.contains("force")) {
    nlohmann::json& force = status["force"];
    force["last_N"] = sample.force_base_N;
    force["contact"] = (sample.flags & protocol::kToolContact) != 0;
  }
}

base::Result<nlohmann::json> FetchStatus(const std::string& socket_path) {
  auto connection = ConnectToService(socket_path);
  if (!connection.ok()) return base::Error{connection.error()};
  base::Result<nlohmann::json> status = RequestStatus(**connection);
  protocol::ToolSample sample;
  if (status.ok() && (*connection)->state() != nullptr && (*connection)->state()->ReadNewest(sample)) {
    AddNewestSample(sample, base::MonotonicNow_ns(), *status);
  }
  return status;
}

}  // namespace omni::tools
