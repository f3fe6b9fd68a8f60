// A service whose state memory the test can fill with anything: random words, torn cells, samples that are complete but
// absurd. The socket and the handshake are the real ones.
#pragma once

#include <memory>

#include "service/ipc/server.h"
#include "service/protocol/state_memory.h"
#include "tests/layer/fuzz/random.h"

namespace omni::test {

class GarbageService : private ipc::ServerHandler {
 public:
  GarbageService();  // on $OMNI_SOCKET, with a pen at rest
  ~GarbageService() override;

  // Publishes a valid current sample, so that the pen is present.
  void Heal();
  // Does one kind of damage.
  void Scribble(Random& random);

 private:
  void OnClient(const ipc::ClientInfo&) override {}
  void OnGone(ipc::ClientId) override {}
  // Where the base stands is unknown; without an answer each application would wait for one.
  void OnRequest(ipc::ClientId id, const protocol::Request& request, base::UniqueFd /*file*/) override {
    if (std::holds_alternative<protocol::BasePoseRequest>(request)) server_->Send(id, protocol::BasePose{});
  }
  void OnPeriod(std::int64_t) override {}
  std::string StatusJson() override { return "{}"; }

  void Publish(const protocol::ToolSample& sample, const protocol::InputSnapshot& inputs);
  protocol::ToolSample Absurd(Random& random);

  int fd_ = -1;
  protocol::StateMemory* memory_ = nullptr;
  std::uint64_t published_ = 0;
  std::unique_ptr<ipc::Server> server_;
};

}  // namespace omni::test
