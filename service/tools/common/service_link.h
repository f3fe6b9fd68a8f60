// Requests omnid's status and completes it from the state memory.
#pragma once

#include <memory>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/client/connection.h"

namespace omni::tools {

// An established connection. The error names the socket, why, and how to start omnid.
base::Result<std::unique_ptr<client::Connection>> ConnectToService(
    const std::string& socket_path, protocol::ClientRole role = protocol::ClientRole::kMonitor);

// Waits for the answer, 2 s at most. An answer that is no JSON object is an error.
base::Result<nlohmann::json> RequestStatus(client::Connection& connection);

// Waits for the answer, 30 s at most: a large surface takes a while to be written. A refusal counts as an answer.
base::Result<client::SceneAnswer> RequestScene(client::Connection& connection, protocol::SceneAction action,
                                               std::uint64_t client_id, const std::string& object);

// Adds /tracking and /force from the newest sample of the state memory if the service's status lacks them.
void AddNewestSample(const protocol::ToolSample& sample, std::int64_t now_ns, nlohmann::json& status);

// All three. Error: no service answers, with the remedy.
base::Result<nlohmann::json> FetchStatus(const std::string& socket_path);

}  // namespace omni::tools
