// The page's server against browsers, and against what is none: through real sockets.
#include "service/monitor/web/web_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "service/base/clock.h"
#include "tests/monitor/web_client.h"

namespace omni::monitor {
namespace test_monitor_web_server {

namespace fs = std::filesystem;
using test::WebClient;

constexpr const char* kToken = "0123456789abcdef0123456789abcdef";
constexpr std::size_t kMaxMessage = 5000;

struct Heard : WebHandler {
  void OnPage(PageId page) override { pages.push_back(page); }
  void OnText(PageId /*page*/, std::string_view text) override { texts.emplace_back(text); }
  void OnBytes(PageId /*page*/, std::string_view bytes) override { binaries.emplace_back(bytes); }
  void OnPageGone(PageId page) override { gone.push_back(page); }
  std::string HelloJson() override { return "{\"protocol\":1}"; }
  std::vector<PageId> pages, gone;
  std::vector<std::string> texts, binaries;
};

class WebServerTest : public testing::Test {
 protected:
  WebServerTest() {
    folder_ = fs::path(testing::TempDir()) / ("omni_page_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    std::ofstream(folder_ / "index.html") << "<!doctype html>the page";
    std::ofstream(folder_ / "page.js") << "1";
    std::ofstream(folder_ / "secret.txt") << "secret";
    auto made = WebServer::Listen(
        {.token = kToken, .folder = folder_.string(), .max_pages = 3, .max_message_bytes = kMaxMessage}, heard_);
    server_ = std::move(made.value());
  }
  ~WebServerTest() override { fs::remove_all(folder_); }

  WebClient Client() {
    return WebClient(server_->port(), [this] { server_->RunUntil(base::MonotonicNow_ns() + 1'000'000); });
  }
  std::string Host() const { return "Host: 127.0.0.1:" + std::to_string(server_->port()) + "\r\n"; }
  std::string Origin() const { return "Origin: http://127.0.0.1:" + std::to_string(server_->port()) + "\r\n"; }
  static std::string Protocols(const std::string& token = kToken) {
    return "Sec-WebSocket-Protocol: omni-page, token." + token + "\r\n";
  }
  std::string Get(const std::string& target, const std::string& headers) { return Client().Get(target, headers); }
  std::string StatusOfUpgrade(const std::string& headers, const std::string& target = "/live") {
    return Client().Upgrade(target, headers);
  }
  // The client may have the answer before the server's own handler has run.
  bool HearsPages(std::size_t count) {
    for (int i = 0; i < 1000 && heard_.pages.size() < count; ++i) {
      server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
    }
    return heard_.pages.size() == count;
  }

  fs::path folder_;
  Heard heard_;
  std::unique_ptr<WebServer> server_;
};

TEST_F(WebServerTest, ServesThePageWithAStrictPolicy) {
  const std::string page = Get("/", Host());
  EXPECT_EQ(page.rfind("HTTP/1.1 200", 0), 0U) << page;
  EXPECT_NE(page.find("the page"), std::string::npos);
  for (const char* header :
       {"Content-Security-Policy: default-src 'none'; script-src 'self'", "frame-ancestors 'none'",
        "X-Content-Type-Options: nosniff", "Referrer-Policy: no-referrer", "Cache-Control: no-store"}) {
    EXPECT_NE(page.find(header), std::string::npos) << header;
  }
  EXPECT_EQ(page.find("unsafe"), std::string::npos);
}

TEST_F(WebServerTest, ServesOnlyThePagesOwnFiles) {
  for (const char* target :
       {"/secret.txt", "/../secret.txt", "/%2e%2e/etc/passwd", "//etc/passwd", "/page.js/", "/live"}) {
    EXPECT_EQ(Get(target, Host()).rfind("HTTP/1.1 404", 0), 0U) << target;
  }
}

TEST_F(WebServerTest, ForeignHostIsRefused) {
  for (const char* host : {"Host: evil.example\r\n", "Host: evil.example:80\r\n", ""}) {
    EXPECT_EQ(Get("/", host).rfind("HTTP/1.1 403", 0), 0U) << host;
    EXPECT_EQ(StatusOfUpgrade(host + Origin() + Protocols()).rfind("HTTP/1.1 403", 0), 0U) << host;
  }
  EXPECT_TRUE(heard_.pages.empty());
}

TEST_F(WebServerTest, ForeignOriginIsRefused) {
  for (const char* origin : {"Origin: http://evil.example\r\n", "Origin: null\r\n", "Origin: http://127.0.0.1:1\r\n"}) {
    EXPECT_EQ(StatusOfUpgrade(Host() + origin + Protocols()).rfind("HTTP/1.1 403", 0), 0U) << origin;
    const std::string token = "Authorization: Bearer " + std::string(kToken) + "\r\n";
    EXPECT_EQ(Get("/hello", Host() + origin + token).rfind("HTTP/1.1 403", 0), 0U) << origin;
  }
  EXPECT_TRUE(heard_.pages.empty());
}

TEST_F(WebServerTest, TokenIsRequired) {
  for (const std::string& protocols :
       {std::string(), Protocols(""), Protocols("0123"), Protocols("1123456789abcdef0123456789abcdef"),
        Protocols(std::string(kToken) + "0")}) {
    EXPECT_EQ(StatusOfUpgrade(Host() + Origin() + protocols).rfind("HTTP/1.1 403", 0), 0U) << protocols;
  }
  EXPECT_EQ(Get("/hello", Host()).rfind("HTTP/1.1 403", 0), 0U);
  EXPECT_EQ(Get("/hello", Host() + "Authorization: Bearer x\r\n").rfind("HTTP/1.1 403", 0), 0U);
  const std::string hello = Get("/hello", Host() + "Authorization: Bearer " + kToken + "\r\n");
  EXPECT_EQ(hello.rfind("HTTP/1.1 200", 0), 0U);
  EXPECT_NE(hello.find("{\"protocol\":1}"), std::string::npos);
  EXPECT_TRUE(heard_.pages.empty());
}

// What stands in a browser's command line is worth nothing to whoever reads it there later.
TEST_F(WebServerTest, CodeIsGoodOnceForTheToken) {
  const std::string code(32, 'c');
  Heard other;
  const auto made = WebServer::Listen({.token = kToken, .code = code, .folder = folder_.string()}, other);
  ASSERT_TRUE(made.ok());
  const auto hello = [&](const std::string& authorization) {
    WebClient client((*made)->port(), [&] { (*made)->RunUntil(base::MonotonicNow_ns() + 1'000'000); });
    return client.Get("/hello", "Host: 127.0.0.1:" + std::to_string((*made)->port()) +
                                    "\r\nAuthorization: " + authorization + "\r\n");
  };
  EXPECT_EQ(hello("Bearer " + code).rfind("HTTP/1.1 403", 0), 0U);
  EXPECT_EQ(hello("Code " + std::string(32, 'd')).rfind("HTTP/1.1 403", 0), 0U);
  EXPECT_NE(hello("Code " + code).find(kToken), std::string::npos);
  EXPECT_EQ(hello("Code " + code).rfind("HTTP/1.1 403", 0), 0U);
  EXPECT_EQ(hello("Code ").rfind("HTTP/1.1 403", 0), 0U);
}

// As another user: whether this server answers at all. Exits with 1 if it does.
[[noreturn]] void AskAsOther(std::uint16_t port) {
  constexpr uid_t kNobody = 65534;
  if (::setresuid(kNobody, kNobody, kNobody) != 0) ::_exit(2);
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) ::_exit(3);
  const std::string request = "GET / HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n\r\n";
  ::send(socket, request.data(), request.size(), MSG_NOSIGNAL);
  char byte = 0;
  ::_exit(::recv(socket, &byte, 1, 0) > 0 ? 1 : 0);
}

TEST_F(WebServerTest, OtherUsersOfThisMachineAreRefused) {
  if (::geteuid() == 0) {
    const pid_t child = ::fork();
    if (child == 0) AskAsOther(server_->port());
    int status = 0;
    while (::waitpid(child, &status, WNOHANG) == 0) server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
    EXPECT_EQ(WEXITSTATUS(status), 0);
  }
  Heard other;
  const auto made = WebServer::Listen({.token = kToken, .user = ::geteuid() + 1, .folder = folder_.string()}, other);
  ASSERT_TRUE(made.ok());
  WebClient client((*made)->port(), [&] { (*made)->RunUntil(base::MonotonicNow_ns() + 1'000'000); });
  const std::string answer = client.Get("/", "Host: 127.0.0.1:" + std::to_string((*made)->port()) + "\r\n");
  EXPECT_EQ(answer.empty(), ::geteuid() != 0) << "root may everything anyway";
}

TEST_F(WebServerTest, OtherMethodsAndLargeRequestsAreRefused) {
  WebClient post = Client();
  post.Send("POST / HTTP/1.1\r\n" + Host() + "\r\n");
  EXPECT_EQ(post.ReadAll().rfind("HTTP/1.1 405", 0), 0U);
  WebClient body = Client();
  body.Send("GET / HTTP/1.1\r\n" + Host() + "Content-Length: 10\r\n\r\n0123456789");
  EXPECT_NE(body.ReadAll().rfind("HTTP/1.1 200", 0), 0U);
  WebClient large = Client();
  large.Send("GET / HTTP/1.1\r\n" + Host() + "X: " + std::string(100'000, 'x') + "\r\n\r\n");
  EXPECT_NE(large.ReadAll().rfind("HTTP/1.1 200", 0), 0U);
  WebClient noise = Client();
  noise.Send(std::string(5000, '\xff'));
  noise.ReadAll();
  EXPECT_EQ(Get("/", Host()).rfind("HTTP/1.1 200", 0), 0U) << "the server goes on";
}

TEST_F(WebServerTest, MessagesArriveBothWaysInOrder) {
  WebClient client = Client();
  ASSERT_EQ(client.Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
  ASSERT_TRUE(HearsPages(1));
  const PageId page = heard_.pages[0];
  EXPECT_TRUE(server_->IsIdle(page));
  client.SendFrame(1, "one");
  client.SendFrame(2, std::string(4000, 'b'));
  const auto large = std::make_shared<const std::string>(std::string(3 << 20, 'l'));
  server_->Send(page, std::make_shared<const std::string>("first"), false);
  server_->Send(page, large, true);
  EXPECT_FALSE(server_->IsIdle(page));
  const WebClient::Frame first = client.ReadFrame();
  EXPECT_EQ(first.opcode, 1U);
  EXPECT_EQ(first.payload, "first");
  const WebClient::Frame second = client.ReadFrame();
  EXPECT_EQ(second.opcode, 2U);
  EXPECT_TRUE(second.payload == *large);
  for (int i = 0; i < 1000 && heard_.binaries.empty(); ++i) server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
  EXPECT_TRUE(server_->IsIdle(page));
  EXPECT_EQ(heard_.texts, std::vector<std::string>{"one"});
  ASSERT_EQ(heard_.binaries.size(), 1U);
  EXPECT_EQ(heard_.binaries[0].size(), 4000U);
}

TEST_F(WebServerTest, TooManyPagesAreRefusedAndClosedOnesMakeRoom) {
  std::vector<std::unique_ptr<WebClient>> clients;
  for (int i = 0; i < 3; ++i) {
    clients.push_back(std::make_unique<WebClient>(Client()));
    ASSERT_EQ(clients.back()->Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
  }
  EXPECT_EQ(StatusOfUpgrade(Host() + Origin() + Protocols()).rfind("HTTP/1.1 503", 0), 0U);
  ASSERT_TRUE(HearsPages(3));
  clients.erase(clients.begin());
  for (int i = 0; i < 1000 && heard_.gone.empty(); ++i) server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
  EXPECT_EQ(heard_.gone, std::vector<PageId>{heard_.pages[0]});
  EXPECT_EQ(StatusOfUpgrade(Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
}

// A frame that is too large, not masked, or of a kind that there is not, ends its page and no other.
TEST_F(WebServerTest, BadFramesEndOnlyTheirPage) {
  WebClient good = Client();
  ASSERT_EQ(good.Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
  struct Case {
    unsigned opcode;
    std::size_t bytes;
    bool masked;
  };
  for (const Case& bad : {Case{1, kMaxMessage + 1, true}, Case{1, 10, false}, Case{3, 10, true}, Case{9, 200, true}}) {
    const std::size_t gone = heard_.gone.size(), texts = heard_.texts.size();
    {
      WebClient client = Client();
      ASSERT_EQ(client.Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
      client.SendFrame(bad.opcode, std::string(bad.bytes, 'x'), bad.masked);
      EXPECT_EQ(client.ReadFrame().opcode, 8U) << "it is closed: " << bad.opcode << ' ' << bad.bytes;
    }
    for (int i = 0; i < 100 && heard_.gone.size() == gone; ++i) server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
    EXPECT_EQ(heard_.gone.size(), gone + 1) << bad.opcode << ' ' << bad.bytes;
    EXPECT_EQ(heard_.texts.size(), texts);
  }
  WebClient text = Client();
  ASSERT_EQ(text.Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
  text.SendFrame(1, "\xff\xfe\xfd");  // no UTF-8
  text.ReadAll();
  good.SendFrame(1, "still here");
  for (int i = 0; i < 1000 && heard_.texts.empty(); ++i) server_->RunUntil(base::MonotonicNow_ns() + 1'000'000);
  EXPECT_EQ(heard_.texts, std::vector<std::string>{"still here"});
}

TEST_F(WebServerTest, CloseCarriesItsReason) {
  WebClient client = Client();
  ASSERT_EQ(client.Upgrade("/live", Host() + Origin() + Protocols()), "HTTP/1.1 101 Switching Protocols");
  ASSERT_TRUE(HearsPages(1));
  server_->Close(heard_.pages[0], CloseCode::kBadMessage, "why");
  const WebClient::Frame frame = client.ReadFrame();
  EXPECT_EQ(frame.opcode, 8U);
  EXPECT_EQ(frame.payload, std::string("\x0f\xa2why"));
}

// Connections that say nothing keep no one out, nor grow without bound.
TEST_F(WebServerTest, SilentConnectionsAreBounded) {
  std::vector<std::unique_ptr<WebClient>> silent;
  for (int i = 0; i < 200; ++i) {
    silent.push_back(std::make_unique<WebClient>(Client()));
    silent.back()->Send("GET");
  }
  EXPECT_EQ(Get("/", Host()).rfind("HTTP/1.1 200", 0), 0U) << "while all of them are open";
  int refused = 0;
  for (const auto& client : silent) {
    client->ReadAll();
    refused += client->closed() ? 1 : 0;
  }
  EXPECT_GE(refused, 180);
  silent.clear();
  EXPECT_EQ(Get("/", Host()).rfind("HTTP/1.1 200", 0), 0U);
}

TEST_F(WebServerTest, TakenPortIsNamed) {
  Heard other;
  const auto second = WebServer::Listen({.port = server_->port(), .token = kToken, .folder = folder_.string()}, other);
  ASSERT_FALSE(second.ok());
  EXPECT_NE(second.error().find("port " + std::to_string(server_->port())), std::string::npos);
  EXPECT_NE(second.error().find("--port"), std::string::npos);
}

}  // namespace test_monitor_web_server
}  // namespace omni::monitor
