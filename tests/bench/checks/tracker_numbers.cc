// The list of the tracker's numbers is complete, and each can be scaled.
#include "tests/bench/harness/tracker_numbers.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>

namespace omni::bench {
namespace test_bench_tracker_numbers {

// Members with a number for a default, of the structs that Config consists of, as their headers have them.
std::set<std::string> NumbersInHeaders() {
  std::set<std::string> names;
  const std::regex structs(R"(struct (\w*(?:Options|Noise|Trust|Config)) \{([\s\S]*?)\n\};)");
  const std::regex member(R"((\w+)(?: = -?[0-9.]+(?:e-?[0-9]+)?(?=[,;])|\{+[0-9][^;]*\}+;))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(OMNI_SOURCE_DIR "/service/tracker")) {
    if (entry.path().extension() != ".h") continue;
    std::ifstream file(entry.path());
    std::ostringstream read;
    read << file.rdbuf();
    const std::string text = std::regex_replace(read.str(), std::regex("//[^\n]*"), "");
    for (std::sregex_iterator of(text.begin(), text.end(), structs), end; of != end; ++of) {
      const std::string body = (*of)[2];
      for (std::sregex_iterator m(body.begin(), body.end(), member); m != end; ++m) names.insert((*m)[1]);
    }
  }
  return names;
}

TEST(TrackerNumbers, ListIsComplete) {
  tracker::Config config;
  std::set<std::string> listed;
  for (const TrackerNumber& number : TrackerNumbers(config)) {
    EXPECT_TRUE(listed.insert(number.name).second) << number.name << " is listed twice";
  }
  std::set<std::string> members;
  for (const std::string& name : listed) members.insert(name.substr(name.rfind('.') + 1));
  std::set<std::string> headers = NumbersInHeaders();
  // Set by MakeConfig or by a caller, of no default that could be scaled, or not of the configuration.
  for (const char* other :
       {"known_count", "sensors_out", "parameters", "damping", "warm_iterations_max", "cold_candidates", "gap_max_m"}) {
    headers.erase(other);
  }
  EXPECT_EQ(members, headers);
}

TEST(TrackerNumbers, EachIsScaled) {
  tracker::Config config;
  for (const TrackerNumber& number : TrackerNumbers(config)) {
    const double before = ValueOf(number);
    Scale(1.4, number);
    if (before != 0) {
      EXPECT_NE(ValueOf(number), before) << number.name;
    }
  }
}

}  // namespace test_bench_tracker_numbers
}  // namespace omni::bench
