// Socket activation: the socket is systemd's, omnid starts with the first application and ends when nobody needs it.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/unique_fd.h"
#include "service/protocol/socket_path.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_activation {

// What systemd does for omnid.socket and omnid.service.
class SocketUnit {
 public:
  explicit SocketUnit(int type = SOCK_SEQPACKET) {
    std::filesystem::create_directory(folder_.Path("omni"));
    std::filesystem::permissions(folder_.Path("omni"), std::filesystem::perms::owner_all);
    socket_ = base::UniqueFd(::socket(AF_UNIX, type | SOCK_CLOEXEC, 0));
    const protocol::SocketAddress at = protocol::AddressOf(path());
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&at.address), at.bytes), 0);
    EXPECT_EQ(::listen(socket_.get(), 16), 0);
  }
  ~SocketUnit() {
    if (pid_ > 0) {
      ::kill(pid_, SIGTERM);
      EXPECT_EQ(Wait(), 0);
    }
  }
  SocketUnit(const SocketUnit&) = delete;
  SocketUnit& operator=(const SocketUnit&) = delete;

  std::string path() const { return folder_.Path("omni/omnid.sock"); }
  bool runs() const { return pid_ > 0; }
  std::string log() const {
    std::ifstream in(folder_.Path("log"));
    return {std::istreambuf_iterator<char>(in), {}};
  }

  // Whether somebody waits to be accepted.
  bool IsWanted() const {
    pollfd wait{.fd = socket_.get(), .events = POLLIN, .revents = 0};
    return ::poll(&wait, 1, 0) == 1;
  }

  void Start(const std::vector<std::string>& more, int count = 1) {
    std::vector<std::string> words{OMNI_BINARY_DIR "/bin/omnid", "--device", "usb", "--no-realtime"};
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const std::string home = "XDG_CONFIG_HOME=" + folder_.Path(""), cache = "XDG_CACHE_HOME=" + folder_.Path(""),
                      state = "XDG_STATE_HOME=" + folder_.Path("");
    const std::string log = folder_.Path("log"), fds = "LISTEN_FDS=" + std::to_string(count);
    pid_ = ::fork();
    if (pid_ != 0) return;
    char pid[32];
    std::snprintf(pid, sizeof(pid), "LISTEN_PID=%d", ::getpid());
    const char* const environment[] = {home.c_str(), cache.c_str(), state.c_str(), fds.c_str(), pid, nullptr};
    ::dup2(::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600), STDERR_FILENO);
    ::dup2(socket_.get(), 3);
    ::execve(arguments[0], arguments.data(), const_cast<char* const*>(environment));
    ::_exit(127);
  }

  void Kill() const { ::kill(pid_, SIGKILL); }
  int Wait() {
    int status = 0;
    EXPECT_EQ(::waitpid(pid_, &status, 0), pid_);
    pid_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  TempFolder folder_;
  base::UniqueFd socket_;
  pid_t pid_ = -1;
};

TEST(Activation, OmnidStartsForAnApplicationAndEndsWithoutOne) {
  SocketUnit unit;
  struct stat before {
  }, after{};
  ASSERT_EQ(::lstat(unit.path().c_str(), &before), 0);
  for (int round = 0; round < 2; ++round) {
    SCOPED_TRACE(round);
    {
      TestApplication app(unit.path(), "test");
      ASSERT_TRUE(app.Run(5000, 5, [&] { return unit.IsWanted(); }));
      EXPECT_FALSE(app.connection().connected());
      unit.Start({"--exit-idle", "0.3"});
      ASSERT_TRUE(app.Run(10'000, 5, [&] { return app.connection().connected(); })) << unit.log();
      app.Run(600, 5);  // longer than --exit-idle
      EXPECT_TRUE(app.connection().connected());
    }
    EXPECT_EQ(unit.Wait(), 0) << unit.log();
    ASSERT_EQ(::lstat(unit.path().c_str(), &after), 0) << "the socket is systemd's";
    EXPECT_EQ(before.st_ino, after.st_ino);
  }
}

TEST(Activation, WhoLooksDoesNotStartIt) {
  using Words = std::vector<std::string>;
  SocketUnit unit;
  const auto run = [&](Words words) {
    words.insert(words.end(), {"--socket", unit.path()});
    const Outcome said = RunOmni(words);
    EXPECT_FALSE(unit.IsWanted());
    return said;
  };
  for (const Words& words : {Words{"status"}, Words{"status", "--json"}, Words{"stop"}, Words{"scene", "edits"},
                             Words{"monitor", "--csv", "/tmp/none.csv"}}) {
    SCOPED_TRACE(words.front());
    const Outcome said = run(words);
    EXPECT_EQ(said.status, tools::kExitNoService);
    EXPECT_NE(said.err.find("systemd starts it"), std::string::npos) << said.err;
  }
  for (const Words& words : {Words{"doctor"}, Words{"watch", "--seconds", "0.3"}}) {
    SCOPED_TRACE(words.front());
    run(words);
  }
}

TEST(Activation, WithoutABaseItWaitsForOneAndIsNoSimulation) {
  SocketUnit unit;
  unit.Start({});
  TestApplication app(unit.path(), "test");
  ASSERT_TRUE(app.Run(10'000, 5, [&] { return app.connection().connected(); })) << unit.log();
  const Outcome said = RunOmni({"status", "--json", "--socket", unit.path()});
  ASSERT_EQ(said.status, 0) << said.err;
  const nlohmann::json status = nlohmann::json::parse(said.out);
  EXPECT_FALSE(status["device"].value("simulation", false)) << said.out;
}

TEST(Activation, AnEmergencyStopOutlivesItsClients) {
  SocketUnit unit;
  unit.Start({"--exit-idle", "0.3"});
  {
    TestApplication app(unit.path(), "test");
    ASSERT_TRUE(app.Run(10'000, 5, [&] { return app.connection().connected(); })) << unit.log();
    ASSERT_EQ(RunOmni({"stop", "--socket", unit.path()}).status, 0);
  }
  SleepMs(800);
  ASSERT_EQ(RunOmni({"status", "--socket", unit.path()}).status, 0) << unit.log();
  ASSERT_EQ(RunOmni({"stop", "--release", "--socket", unit.path()}).status, 0);
  EXPECT_EQ(unit.Wait(), 0);
}

TEST(Activation, AnEmergencyStopOutlivesACrash) {
  SocketUnit unit;
  const auto is_stopped = [&] {
    TestApplication app(unit.path(), "test");
    EXPECT_TRUE(app.Run(10'000, 5, [&] { return app.connection().connected(); })) << unit.log();
    const Outcome said = RunOmni({"status", "--json", "--socket", unit.path()});
    return !nlohmann::json::parse(said.out)["stopped"].is_null();
  };
  unit.Start({});
  EXPECT_FALSE(is_stopped());
  const Outcome said = RunOmni({"stop", "--socket", unit.path()});
  EXPECT_EQ(said.status, 0) << said.err;
  unit.Kill();
  EXPECT_EQ(unit.Wait(), 128 + SIGKILL);
  unit.Start({"--exit-idle", "0.3"});
  EXPECT_TRUE(is_stopped());
  EXPECT_NE(unit.log().find("before this omnid started"), std::string::npos) << unit.log();
  EXPECT_EQ(RunOmni({"stop", "--release", "--socket", unit.path()}).status, 0);
  EXPECT_EQ(unit.Wait(), 0);
  unit.Start({"--exit-idle", "0.3"});
  EXPECT_FALSE(is_stopped());
  EXPECT_EQ(unit.Wait(), 0);
}

TEST(Activation, AnotherKindOfSocketIsRefused) {
  {
    SocketUnit unit(SOCK_STREAM);
    unit.Start({});
    EXPECT_EQ(unit.Wait(), 1);
    EXPECT_NE(unit.log().find("ListenSequentialPacket="), std::string::npos) << unit.log();
  }
  {
    SocketUnit unit;
    unit.Start({}, 2);
    EXPECT_EQ(unit.Wait(), 1);
    EXPECT_NE(unit.log().find("2 sockets, must be 1"), std::string::npos) << unit.log();
  }
  {
    SocketUnit unit;
    unit.Start({"--socket", "/tmp/another.sock"});
    EXPECT_EQ(unit.Wait(), 1);
    EXPECT_NE(unit.log().find(unit.path()), std::string::npos) << unit.log();
  }
}

}  // namespace test_process_activation
}  // namespace omni::test
