// Who may use the page.
#include "service/monitor/web/access.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace omni::monitor {
namespace test_monitor_access {

TEST(PageAccess, TokensAreLongAndNeverRepeat) {
  std::set<std::string> tokens;
  for (int i = 0; i < 1000; ++i) {
    const std::string token = MakeToken().value();
    EXPECT_EQ(token.size(), 32U);
    EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
    tokens.insert(token);
  }
  EXPECT_EQ(tokens.size(), 1000U);
}

TEST(PageAccess, OnlyTheWholeTokenIsTheToken) {
  const std::string token = MakeToken().value();
  EXPECT_TRUE(SameToken(token, token));
  EXPECT_FALSE(SameToken("", token));
  EXPECT_FALSE(SameToken("", ""));
  for (std::size_t i = 0; i < token.size(); ++i) {
    std::string other = token;
    other[i] = other[i] == '0' ? '1' : '0';
    EXPECT_FALSE(SameToken(other, token)) << i;
    EXPECT_FALSE(SameToken(token.substr(0, i), token)) << i;
  }
  EXPECT_FALSE(SameToken(token + "0", token));
}

TEST(PageAccess, HostIsALoopbackNameWithThePort) {
  for (const char* host : {"127.0.0.1:8000", "localhost:8000", "[::1]:8000"})
    EXPECT_TRUE(HostAllowed(host, 8000)) << host;
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:80000", "evil.example:8000", "localhost.evil:8000",
        "127.0.0.1:8000@evil", "evil:127.0.0.1:8000", "0.0.0.0:8000", "127.0.0.1 :8000"}) {
    EXPECT_FALSE(HostAllowed(host, 8000)) << host;
  }
}

TEST(PageAccess, OriginIsThisServer) {
  EXPECT_TRUE(OriginAllowed("http://127.0.0.1:8000", 8000));
  EXPECT_TRUE(OriginAllowed("http://localhost:8000", 8000));
  for (const char* origin : {"", "null", "https://127.0.0.1:8000", "http://127.0.0.1:8001", "http://evil.example",
                             "http://127.0.0.1:8000.evil.example", "file://", "http://127.0.0.1:8000/"}) {
    EXPECT_FALSE(OriginAllowed(origin, 8000)) << origin;
  }
}

TEST(PageAccess, TokenIsReadFromBothHeaders) {
  EXPECT_EQ(BearerToken("Bearer abc"), "abc");
  EXPECT_EQ(BearerToken("Basic abc"), "");
  EXPECT_EQ(ProtocolToken("omni-page, token.abc"), "abc");
  EXPECT_EQ(ProtocolToken("token.abc,omni-page"), "abc");
  EXPECT_EQ(ProtocolToken("omni-page"), "");
  EXPECT_EQ(ProtocolToken(""), "");
}

}  // namespace test_monitor_access
}  // namespace omni::monitor
