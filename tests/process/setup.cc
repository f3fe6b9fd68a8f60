// omni setup as a process: the rehearsal from nothing to a force, single steps, what is taken back, what fails.
#include <gtest/gtest.h>

#include <signal.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/process/child_process.h"
#include "tests/support/process/temp_folder.h"

namespace omni::test {
namespace test_process_setup {

namespace fs = std::filesystem;

struct Ran {
  int status = -1;
  std::string text;  // of both outputs
};

// A person whose home is a folder of the test, without a base and without a systemd session.
class Person {
 public:
  std::string Path(const std::string& below) const { return folder_.Path(below); }
  void Write(const std::string& below, const std::string& text) const { folder_.Write(below, text); }

  Ran Setup(const std::vector<std::string>& words, const std::string& answers = "",
            const std::string& more_environment = "OMNI_TEST=1") const {
    std::string command = "exec \"$0\" setup \"$@\" 2>&1 <'" + folder_.Write("answers", answers) + "'";
    std::vector<std::string> all{"/bin/sh", "-c", command, OMNI_BINARY_DIR "/bin/omni"};
    all.insert(all.end(), words.begin(), words.end());
    auto child = ChildProcess::Start(
        all,
        {"HOME=" + folder_.Path("home"), "XDG_CONFIG_HOME=" + folder_.Path("home/config"),
         "XDG_DATA_HOME=" + folder_.Path("home/data"), "OMNI_SOCKET=" + folder_.Path("run/omnid.sock"),
         "XDG_CACHE_HOME=" + std::string(OMNI_BINARY_DIR) + "/tests/setup_cache",
         "XDG_RUNTIME_DIR=", "DBUS_SESSION_BUS_ADDRESS=", "COLUMNS=", more_environment},
        folder_.Path("said"));
    if (!child.ok()) return {-1, child.error()};
    Ran ran;
    ran.status = child->Wait();
    std::ifstream in(folder_.Path("said"));
    ran.text.assign(std::istreambuf_iterator<char>(in), {});
    return ran;
  }

 private:
  TempFolder folder_;
};

void ExpectSays(const Ran& ran, const std::string& words) {
  EXPECT_NE(ran.text.find(words), std::string::npos) << words << "\nis not in\n" << ran.text;
}

TEST(ProcessSetup, RehearsalGoesFromNothingToAForceAndChangesNothing) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "its forces are made in real time, for which ThreadSanitizer is too slow";
#endif
  const Person person;
  const Ran ran = person.Setup({"--rehearse", "--yes"});
  EXPECT_EQ(ran.status, 0) << ran.text;
  ExpectSays(ran, "REHEARSAL");
  ExpectSays(ran, "done: calibrated: ");
  ExpectSays(ran, "done: the base's place in the headset's space is stored");
  ExpectSays(ran, "done: applications get the pen");
  ExpectSays(ran, "done: largest forces: extrusion ");
  ExpectSays(ran, "8 of 8");
  ExpectSays(ran, "Set up in ");
  EXPECT_EQ(ran.text.find("FAILED"), std::string::npos) << ran.text;
  EXPECT_FALSE(fs::exists(person.Path("home"))) << "something of the person's was written";
}

TEST(ProcessSetup, StepsAreListed) {
  const Person person;
  const Ran text = person.Setup({"--list"});
  EXPECT_EQ(text.status, 0);
  const Ran json = person.Setup({"--json"});
  EXPECT_EQ(json.status, 0);
  const nlohmann::json steps = nlohmann::json::parse(json.text);
  ASSERT_EQ(steps.size(), 8U);
  for (const nlohmann::json& step : steps) ExpectSays(text, step["title"]);
}

// The state of a step is what the user's files show.
TEST(ProcessSetup, ListSaysWhatIsDone) {
  const Person person;
  const auto state_of = [&](const char* name) {
    const nlohmann::json steps = nlohmann::json::parse(person.Setup({"--json"}).text);
    for (const nlohmann::json& step : steps) {
      if (step["name"] == name) return step["state"].get<std::string>();
    }
    return std::string("no such step");
  };
  for (const char* name : {"device", "calibrate", "align", "inputs", "layer"}) EXPECT_EQ(state_of(name), "open");
  EXPECT_EQ(state_of("scenes"), "unknown");
  person.Write("home/config/omni/inputs.toml", "# Written by omni setup.\nhand = \"left\"\n");
  EXPECT_EQ(state_of("inputs"), "done");
  EXPECT_EQ(person.Setup({"--undo", "inputs"}).status, 0);
  EXPECT_EQ(state_of("inputs"), "open");
  EXPECT_EQ(person.Setup({"layer", "--yes"}).status, 0);
  EXPECT_EQ(state_of("layer"), "done");
  person.Write("home/config/omni/alignments.toml", "this is no TOML");
  EXPECT_EQ(state_of("align"), "open");
}

// Its omnid, its simulated hand and their twin end with it, however it ends.
TEST(ProcessSetup, NothingOutlivesAKilledSetup) {
  const Person person;
  const std::string log = person.Path("rehearsal");
  const auto running = [&] {
    int count = 0;
    for (const fs::directory_entry& process : fs::directory_iterator("/proc")) {
      std::ifstream in(process.path() / "environ");
      const std::string environment(std::istreambuf_iterator<char>(in), {});
      if (environment.find("XDG_RUNTIME_DIR=" + person.Path("")) != std::string::npos) ++count;
    }
    return count;
  };
  auto setup =
      ChildProcess::Start({std::string(OMNI_BINARY_DIR) + "/bin/omni", "setup", "scenes", "--rehearse", "--yes"},
                          {"HOME=" + person.Path("home"), "XDG_RUNTIME_DIR=" + person.Path("")}, log);
  ASSERT_TRUE(setup.ok()) << setup.error();
  const auto wait_for = [&](const std::function<bool()>& reached) {
    for (int i = 0; i < 600 && !reached(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
    return reached();
  };
  ASSERT_TRUE(wait_for([&] { return running() >= 4; })) << "setup, omnid, omni-twin, hand; there are " << running();
  ::kill(setup->pid(), SIGKILL);
  EXPECT_TRUE(wait_for([&] { return running() == 0; })) << running() << " still run";
}

TEST(ProcessSetup, NoBaseIsNamedWithWhatToDo) {
  const Person person;
  const Ran ran = person.Setup({"--yes"});
  EXPECT_EQ(ran.status, 1);
  ExpectSays(ran, "FAILED: ");
  ExpectSays(ran, "`omni setup device` tries it again");
  EXPECT_EQ(ran.text.find("2 of 8"), std::string::npos) << "it goes no further\n" << ran.text;
}

TEST(ProcessSetup, LayerIsEnabledOnceAndTakenBack) {
  const Person person;
  const std::string manifest = person.Path("home/data/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json");
  EXPECT_EQ(person.Setup({"layer"}, "n\n").status, 0);
  EXPECT_FALSE(fs::exists(manifest));
  const Ran enabled = person.Setup({"layer"}, "y\n");
  EXPECT_EQ(enabled.status, 0) << enabled.text;
  ExpectSays(enabled, "to take it back: omni setup --undo layer");
  EXPECT_TRUE(fs::exists(manifest));
  EXPECT_EQ(person.Setup({"--undo", "layer"}).status, 0);
  EXPECT_FALSE(fs::exists(manifest));
}

TEST(ProcessSetup, UnwritableHomeIsNamed) {
  const Person person;
  person.Write("home/data", "a file where a folder should be");
  const Ran ran = person.Setup({"layer", "--yes"});
  EXPECT_EQ(ran.status, 1) << ran.text;
  ExpectSays(ran, person.Path("home/data"));
  ExpectSays(ran, "\"Give applications the pen\" failed");
}

TEST(ProcessSetup, TheUsersOwnInputsStay) {
  const Person person;
  const std::string mine = "[inputs]\nmenu = []\n";
  person.Write("home/config/omni/inputs.toml", mine);
  const Ran undone = person.Setup({"--undo", "inputs"});
  EXPECT_EQ(undone.status, 1);
  ExpectSays(undone, "is not of omni setup");
  std::ifstream in(person.Path("home/config/omni/inputs.toml"));
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(in), {}), mine);
}

// With a systemctl that knows omnid.socket and cannot enable it.
TEST(ProcessSetup, SystemdThatRefusesIsNamed) {
  const Person person;
  person.Write("bin/systemctl", "#!/bin/sh\n[ \"$2\" = cat ] || { echo 'Failed to connect to bus' >&2; exit 1; }\n");
  fs::permissions(person.Path("bin/systemctl"), fs::perms::owner_all);
  const Ran ran = person.Setup({"start", "--yes"}, "", "PATH=" + person.Path("bin") + ":/usr/bin:/bin");
  EXPECT_EQ(ran.status, 1) << ran.text;
  ExpectSays(ran, "Failed to connect to bus");
  ExpectSays(ran, "\"Start with your session\" failed");
}

TEST(ProcessSetup, WhatCannotBeTakenBackIsRefused) {
  const Person person;
  EXPECT_EQ(person.Setup({"--undo", "device"}).status, 2);
  EXPECT_EQ(person.Setup({"--undo"}).status, 2);
  EXPECT_EQ(person.Setup({"nothing"}).status, 2);
}

}  // namespace test_process_setup
}  // namespace omni::test
