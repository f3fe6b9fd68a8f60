// The layer and the client library run inside of other people's programs, some of which are set-uid: they read the
// environment by secure_getenv only (service/protocol/environment.h).
#include <gtest/gtest.h>

#include <regex>
#include <sstream>
#include <string>

#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

bool ReadsPlainEnvironment(const std::string& line) {
  static const std::regex plain(R"((^|[^A-Za-z0-9_])(getenv|environ|__environ)([^A-Za-z0-9_.]|$))");
  const std::string code = line.substr(0, line.find("//"));
  return std::regex_search(code, plain);
}

TEST(Environment, LayerAndClientsUseOnlySecureGetenv) {
  const SourceTree tree =
      ReadTree(OMNI_SOURCE_DIR, {"layer/src", "layer/include", "service/client", "service/protocol"});
  EXPECT_GT(tree.size(), 100U) << "the sources were found";
  for (const auto& [path, text] : tree) {
    std::istringstream lines(text);
    int number = 0;
    for (std::string line; std::getline(lines, line);) {
      ++number;
      if (ReadsPlainEnvironment(line)) ADD_FAILURE() << path << ":" << number << ": use omni::protocol::Environment";
    }
  }
}

TEST(Environment, ScannerDetectsPlainGetenv) {
  for (const char* line :
       {"std::getenv(\"X\")", "  getenv(\"X\");", "x = ::getenv (name)", "for (char** e = environ; *e;)"})
    EXPECT_TRUE(ReadsPlainEnvironment(line)) << line;
  for (const char* line : {"::secure_getenv(name)", "// not getenv(3)", "#include \"service/protocol/environment.h\"",
                           "protocol::Environment(\"OMNI_HAND\")"})
    EXPECT_FALSE(ReadsPlainEnvironment(line)) << line;
}

}  // namespace
}  // namespace omni::architecture
