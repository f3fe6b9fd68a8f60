// Scene commands and their answers, with and without a file, over the real socket.
#include <gtest/gtest.h>

#include <vector>

#include "service/base/sealed_memory.h"
#include "tests/ipc/fixture.h"

namespace omni {
namespace test_ipc_scene {

using namespace test;
using protocol::SceneAction;

struct SceneReplyParts {
  std::uint32_t number = 0;  // of the command
  bool done = false;
  std::string text{};
  int file = -1;  // goes along if file_bytes > 0
  std::uint64_t file_bytes = 0;
};

// A service that answers every scene command at once.
struct SceneService {
  using Answer = std::function<SceneReplyParts(const protocol::SceneCommand&)>;
  SceneService(const std::string& path, const Answer& answer)
      : service(path, 77, [answer](ipc::ServerOptions&, RecordingHandler& handler) {
          handler.on_scene_command = [&handler, answer](ipc::ClientId id, const protocol::SceneCommand& command) {
            const SceneReplyParts parts = answer(command);
            protocol::SceneReply reply;
            reply.number = parts.number;
            reply.done = parts.done ? 1 : 0;
            reply.file_bytes = parts.file_bytes;
            handler.server->Send(id, reply, parts.text, parts.file_bytes > 0 ? parts.file : -1);
          };
        }) {}
  Service service;
};

std::optional<client::SceneAnswer> AnswerOf(client::Connection& connection) {
  std::optional<client::SceneAnswer> answer;
  Eventually([&] {
    connection.Poll(base::MonotonicNow_ns());
    return (answer = connection.PopSceneAnswer()).has_value() || !connection.connected();
  });
  return answer;
}

TEST(SceneCommands, CommandAndItsReplyCarryAllFields) {
  const TempFolder temp;
  SceneService scene(temp.Path("omnid.sock"), [](const protocol::SceneCommand& command) {
    return SceneReplyParts{.number = command.number, .done = false, .text = "clay: nothing to undo"};
  });
  for (const protocol::ClientRole role : {protocol::ClientRole::kMonitor, protocol::ClientRole::kApplication}) {
    client::ConnectionInfo info = InfoFor(temp.Path("omnid.sock"), "asks");
    info.role = role;
    client::Connection connection(info);
    EXPECT_EQ(connection.SendSceneCommand(SceneAction::kUndo, 3, "clay"), 0U) << "not connected";
    ASSERT_TRUE(PollUntilConnected(connection));
    for (std::uint32_t n = 1; n < 4; ++n) {
      ASSERT_EQ(connection.SendSceneCommand(SceneAction::kUndo, 3, "clay"), n);
      const auto answer = AnswerOf(connection);
      ASSERT_TRUE(answer);
      EXPECT_EQ(answer->number, n);
      EXPECT_FALSE(answer->done);
      EXPECT_EQ(answer->text, "clay: nothing to undo");
      EXPECT_TRUE(answer->file.empty());
    }
    const auto heard = scene.service.handler.SceneCommands();
    EXPECT_EQ(heard.back().action, SceneAction::kUndo);
    EXPECT_EQ(heard.back().client_id, 3U);
    EXPECT_STREQ(heard.back().object, "clay");
  }
}

// Files of several sizes come over as they were.
TEST(SceneCommands, FileArrivesAsSealedMemory) {
  const TempFolder temp;
  std::string content;
  SceneService scene(temp.Path("omnid.sock"), [&](const protocol::SceneCommand& command) {
    auto memory = std::make_shared<base::UniqueFd>(std::move(*base::SealedCopy("test", content)));
    static std::vector<std::shared_ptr<base::UniqueFd>> kept;
    kept.push_back(memory);
    return SceneReplyParts{
        .number = command.number, .done = true, .text = "saved", .file = memory->get(), .file_bytes = content.size()};
  });
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "asks"));
  ASSERT_TRUE(PollUntilConnected(connection));
  for (const std::size_t bytes : {1U, 4095U, 4096U, 4097U, 3'000'001U}) {
    content.resize(bytes);
    for (std::size_t i = 0; i < bytes; ++i) content[i] = static_cast<char>(i * 31 + bytes);
    ASSERT_NE(connection.SendSceneCommand(SceneAction::kSave, 0, ""), 0U);
    const auto answer = AnswerOf(connection);
    ASSERT_TRUE(answer) << connection.last_error();
    EXPECT_TRUE(answer->done);
    EXPECT_TRUE(answer->file == content) << bytes;
  }
}

TEST(SceneCommands, InvalidFileEndsTheConnection) {
  const TempFolder temp;
  const auto memory = std::make_shared<base::UniqueFd>(std::move(*base::SealedCopy("test", "0123456789")));
  int which = 0;
  SceneService scene(temp.Path("omnid.sock"), [&](const protocol::SceneCommand& command) {
    return SceneReplyParts{.number = command.number,
                           .done = true,
                           .text = "saved",
                           .file = which == 0 ? memory->get() : 0,  // standard input: no sealed memory
                           .file_bytes = 11};
  });
  for (which = 0; which < 2; ++which) {
    client::Connection connection(InfoFor(temp.Path("omnid.sock"), "asks"));
    ASSERT_TRUE(PollUntilConnected(connection));
    ASSERT_NE(connection.SendSceneCommand(SceneAction::kSave, 0, ""), 0U);
    EXPECT_FALSE(AnswerOf(connection));
    EXPECT_NE(connection.last_error().find("the file in its answer"), std::string::npos) << connection.last_error();
  }
}

TEST(SceneCommands, LongTextIsTruncatedAndServerRejectsReplies) {
  const TempFolder temp;
  SceneService scene(temp.Path("omnid.sock"), [](const protocol::SceneCommand& command) {
    return SceneReplyParts{.number = command.number, .done = true, .text = std::string(100'000, 'x')};
  });
  client::Connection connection(InfoFor(temp.Path("omnid.sock"), "asks"));
  ASSERT_TRUE(PollUntilConnected(connection));
  ASSERT_NE(connection.SendSceneCommand(SceneAction::kEdits, 0, std::string(500, 'o')), 0U);
  const auto answer = AnswerOf(connection);
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->text.size(), protocol::kMaxMessageBytes - sizeof(protocol::SceneReply));
  EXPECT_EQ(std::string(scene.service.handler.SceneCommands().back().object).size(), 127U);
  RawClient raw(temp.Path("omnid.sock"));
  ASSERT_TRUE(raw.Greet("raw"));
  ASSERT_TRUE(raw.Send(protocol::SceneReply{}));
  EXPECT_NE(raw.RejectReason().find("only omnid sends"), std::string::npos);
}

}  // namespace test_ipc_scene
}  // namespace omni
