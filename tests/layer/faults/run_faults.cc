// run_layer_faults: proves that the tests of the rules can fail. With each seeded fault (seeds.json) the tests
// of the rules that it breaks run against the faulty build of the layer; at least one must fail. First all of them run
// against that build without a fault: then all must pass. Prints the table; exit status 1 if a fault survives.
//   run_layer_faults [FAULT...]   only these
#include <sys/wait.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace fs = std::filesystem;

struct Outcome {
  int tests = 0;
  std::vector<std::string> failed;
  std::string death;  // empty: it ran to its end
};

struct Job {
  std::string fault;  // empty: none
  std::set<std::string> tests;
  Outcome outcome;
};

nlohmann::json ReadJson(const fs::path& file) {
  std::ifstream in(file);
  return in ? nlohmann::json::parse(in, nullptr, false) : nlohmann::json();
}

// Fault -> tests of the rules that name it, of this program only.
std::map<std::string, std::set<std::string>> TestsByFault(const nlohmann::json& table) {
  std::map<std::string, std::set<std::string>> tests;
  for (const auto& [fault, what] : table.at("faults").items()) tests[fault];
  for (const nlohmann::json& group : table.at("groups"))
    for (const nlohmann::json& rule : group.at("rules"))
      for (const std::string fault : rule.at("faults"))
        for (const std::string test : rule.at("tests"))
          if (test.rfind("layer.", 0) == 0) tests[fault].insert(test.substr(6));
  return tests;
}

std::string Joined(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ":") + name;
  return text;
}

Outcome Run(const Job& job, const fs::path& report) {
  fs::remove(report);
  const std::string command = "OMNI_LAYER_FAULT='" + job.fault +
                              "' OMNI_TEST_PATIENCE_S=3 OMNI_FUZZ=40 OMNI_TEST_LAYER_PATH='" OMNI_FAULTY_FOLDER
                              "' timeout 60 '" OMNI_TEST_LAYER "' --gtest_filter='" +
                              Joined(job.tests) + "' --gtest_output=json:" + report.string() + " >" + report.string() +
                              ".log 2>&1";
  const int status = std::system(command.c_str());
  Outcome outcome;
  const nlohmann::json root = ReadJson(report);
  if (!root.is_object()) {
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    outcome.death = code == 124 ? "did not end in 60 s" : "died with status " + std::to_string(code);
    return outcome;
  }
  for (const nlohmann::json& suite : root.at("testsuites")) {
    for (const nlohmann::json& test : suite.at("testsuite")) {
      ++outcome.tests;
      if (test.contains("failures"))
        outcome.failed.push_back(suite.at("name").get<std::string>() + "." + test.at("name").get<std::string>());
    }
  }
  return outcome;
}

constexpr int kAtOnce = 12;  // these tests mostly wait

void RunAll(std::vector<Job>& jobs, const fs::path& folder) {
  std::atomic<std::size_t> next{0};
  std::vector<std::thread> workers;
  for (int i = 0; i < kAtOnce; ++i) {
    workers.emplace_back([&, i] {
      for (std::size_t at = next.fetch_add(1); at < jobs.size(); at = next.fetch_add(1))
        jobs[at].outcome = Run(jobs[at], folder / ("report" + std::to_string(i) + ".json"));
    });
  }
  for (std::thread& worker : workers) worker.join();
}

// False: a test fails, or does not run, without any fault.
bool SoundWithoutFault(const std::map<std::string, std::set<std::string>>& tests, const fs::path& folder) {
  std::set<std::string> all;
  for (const auto& [fault, named] : tests) all.insert(named.begin(), named.end());
  std::vector<Job> jobs(2 * kAtOnce);  // in parallel, to save time
  std::size_t at = 0;
  for (const std::string& test : all) jobs[at++ % jobs.size()].tests.insert(test);
  RunAll(jobs, folder);
  int passed = 0;
  for (const Job& job : jobs) {
    for (const std::string& failed : job.outcome.failed) std::printf("fails without a fault: %s\n", failed.c_str());
    if (!job.outcome.death.empty()) std::printf("without a fault the tests: %s\n", job.outcome.death.c_str());
    passed += job.outcome.tests - static_cast<int>(job.outcome.failed.size());
  }
  std::printf("without a fault %d tests of %zu pass\n", passed, all.size());
  return passed == static_cast<int>(all.size());
}

bool Survives(const Job& job) { return job.outcome.failed.empty() && job.outcome.death.empty(); }

// A fault that survived, perhaps on a busy machine, gets a second run; the table says so.
void RunSurvivorsAgain(std::vector<Job>& jobs, const fs::path& folder) {
  for (Job& job : jobs) {
    if (!Survives(job)) continue;
    job.outcome = Run(job, folder / "report-again.json");
    if (!Survives(job)) job.outcome.failed.push_back("in a second run only");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const fs::path folder = fs::path(OMNI_FAULTY_FOLDER) / "run";
  fs::create_directories(folder);
  const nlohmann::json table = ReadJson(OMNI_SOURCE_DIR "/tests/layer/rules/rules.json");
  std::map<std::string, std::set<std::string>> tests = TestsByFault(table);
  const std::set<std::string> only(argv + 1, argv + argc);
  std::vector<Job> jobs;
  for (const auto& [fault, named] : tests)
    if (only.empty() || only.count(fault)) jobs.push_back({fault, named, {}});
  if (!SoundWithoutFault(tests, folder)) return 1;
  RunAll(jobs, folder);
  RunSurvivorsAgain(jobs, folder);
  std::size_t caught = 0;
  std::printf("| fault | caught by |\n|---|---|\n");
  for (const Job& job : jobs) {
    std::string by = job.outcome.death;
    for (const std::string& failed : job.outcome.failed) by += (by.empty() ? "" : ", ") + failed;
    caught += by.empty() ? 0 : 1;
    std::printf("| %s | %s |\n", job.fault.c_str(), by.empty() ? "NOTHING: it survives" : by.c_str());
  }
  std::printf("%zu of %zu faults are caught\n", caught, jobs.size());
  return caught == jobs.size() && !jobs.empty() ? 0 : 1;
}
