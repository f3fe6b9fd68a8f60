// The layer and the client library run inside of other people's programs, some of which are set-uid: they read the
// environment by secure_getenv only (service/protocol/environment.h).
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace omni::architecture {
namespace {

namespace fs = std::filesystem;

bool ReadsPlainEnvironment(const std::string& line) {
  static const std::regex plain(R"((^|[^A-Za-z0-9_])(getenv|environ|__environ)([^A-Za-z0-9_.]|$))");
  const std::string code = line.substr(0, line.find("//"));
  return std::regex_search(code, plain);
}

// "file:line" of every place below `folder`.
std::vector<std::string> PlainReadsIn(const std::string& folder, int& files) {
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(OMNI_SOURCE_DIR) / folder)) {
    const fs::path extension = entry.path().extension();
    if (extension != ".cc" && extension != ".h") continue;
    ++files;
    std::ifstream in(entry.path());
    int number = 0;
    for (std::string line; std::getline(in, line);) {
      ++number;
      if (ReadsPlainEnvironment(line)) found.push_back(entry.path().string() + ":" + std::to_string(number));
    }
  }
  return found;
}

TEST(Environment, LayerAndClientsUseOnlySecureGetenv) {
  int files = 0;
  for (const char* folder : {"layer/src", "layer/include", "service/client", "service/protocol"}) {
    const std::vector<std::string> found = PlainReadsIn(folder, files);
    for (const std::string& place : found) ADD_FAILURE() << place << ": use omni::protocol::Environment";
  }
  EXPECT_GT(files, 100) << "the sources were found";
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
