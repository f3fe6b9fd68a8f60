// OMNI_TEST_RUNTIME_SCRIPT, and the example application as a process of its own under core validation.

#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/runtime/cases/fixture.h"
#include "tests/support/process/temp_folder.h"

namespace omni::runtime {
namespace test_script {

class ScriptTest : public RuntimeTest {
 protected:
  void TearDown() override {
    RuntimeTest::TearDown();
    unsetenv("OMNI_TEST_RUNTIME_SCRIPT");
  }

  std::string File(const std::string& name) const { return folder_.Path(name); }

  void Script(const std::string& text) {
    std::ofstream(File("script")) << text;
    setenv("OMNI_TEST_RUNTIME_SCRIPT", File("script").c_str(), 1);
  }

  std::string Read(const std::string& name) const {
    std::ostringstream text;
    text << std::ifstream(File(name)).rdbuf();
    return text.str();
  }

  // Runs the example application under core validation; its exit status.
  int RunProbe(const std::string& arguments) const {
    const std::string environment =
        "XR_ENABLE_API_LAYERS=XR_APILAYER_LUNARG_core_validation XR_CORE_VALIDATION_EXPORT_TYPE=text "
        "XR_CORE_VALIDATION_FILE_NAME=" +
        File("validation") + " ";
    const std::string command =
        environment + OMNI_PROBE " --json " + File("report.json") + " " + arguments + " > " + File("output") + " 2>&1";
    const int status = std::system(command.c_str());
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  bool ReportHas(const std::string& line) const { return Read("report.json").find(line) != std::string::npos; }

  long Frames() const {
    const std::string key = "\"frames\": ";
    const std::string report = Read("report.json");
    const size_t at = report.find(key);
    return at == std::string::npos ? -1 : std::strtol(report.c_str() + at + key.size(), nullptr, 10);
  }

  const test::TempFolder folder_;
};

TEST_F(ScriptTest, ScriptedEventsHappenAtTheirTime) {
  Script(
      "# comment\n"
      "0 float /user/hand/left/input/trigger/value 0.5\n"
      "1000 float /user/hand/left/input/trigger/value 1.0  # not in this test\n"
      "\n"
      "0 vector2 /user/hand/left/input/thumbstick 0.1 0.2\n");
  Start();
  const XrAction pull = AddAction("pull", XR_ACTION_TYPE_FLOAT_INPUT);
  const XrAction stick = AddAction("stick", XR_ACTION_TYPE_VECTOR2F_INPUT);
  ASSERT_EQ(
      Suggest(kTouchPath, {{pull, "/user/hand/left/input/trigger/value"}, {stick, "/user/hand/left/input/thumbstick"}}),
      XR_SUCCESS);
  AttachAndFocus();
  ASSERT_EQ(Sync(), XR_SUCCESS);
  EXPECT_EQ(Float(pull).currentState, 0.5f);
  EXPECT_EQ(Vector2(stick).currentState.y, 0.2f);
}

TEST_F(ScriptTest, ScriptErrorsFailInstanceCreation) {
  for (const char* const text : {"0 dance\n", "soon reset\n", "0\n", "0 bool /user/hand/left/input/x/click\n",
                                 "0 present middle 1\n", "0 float trigger 1\n", "0 focus nan\n", "-1 reset\n"}) {
    Script(text);
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(CreateInstance({}), XR_ERROR_RUNTIME_FAILURE) << text;
    EXPECT_NE(::testing::internal::GetCapturedStderr().find(File("script") + ":1:"), std::string::npos) << text;
  }
  setenv("OMNI_TEST_RUNTIME_SCRIPT", File("nowhere").c_str(), 1);
  EXPECT_EQ(CreateInstance({}), XR_ERROR_RUNTIME_FAILURE);
}

TEST_F(ScriptTest, ProbeFollowsScriptedHandAndPassesValidation) {
  Script(
      "0.1 pose /user/hand/left/input/aim/pose 0.1 1.6 0  0 0 0 1  0.05 0 0  0 0 0\n"
      "0.2 float /user/hand/left/input/trigger/value 0.9\n"
      "0.3 float /user/hand/left/input/trigger/value 0.1\n"
      "0.4 vector2 /user/hand/left/input/thumbstick 0.6 0.8\n"
      "0.5 float /user/hand/left/input/trigger/value 1.0\n"
      "0.6 focus 0\n"
      "0.7 focus 1\n"
      "0.8 profile left /interaction_profiles/khr/simple_controller\n");
  ASSERT_EQ(RunProbe("--hand left --seconds 1.2 --expect-pen --samples"), 0) << Read("output");
  EXPECT_TRUE(ReportHas("\"profile\": \"" + kSimplePath + "\"")) << Read("report.json");
  EXPECT_TRUE(ReportHas("\"profiles_seen\": [\"" + kTouchPath + "\", \"" + kSimplePath + "\"]"));
  EXPECT_TRUE(ReportHas("\"select_edges\": 3")) << "the second press is seen again after the focus";
  EXPECT_TRUE(ReportHas("\"haptics_sent\": 3"));
  EXPECT_TRUE(ReportHas("\"max_speed_m_s\": 0.05"));
  EXPECT_TRUE(ReportHas("\"errors\": []"));
  EXPECT_NE(Read("output").find("Core Validation output type: text"), std::string::npos) << "validation was loaded";
  EXPECT_EQ(Read("validation"), "");
}

TEST_F(ScriptTest, CoreValidationReportsPlantedError) {
  ASSERT_EQ(RunProbe("--hand left --seconds 0.2 --plant-error"), 0) << Read("output");
  EXPECT_NE(Read("validation").find("VUID-XrSpaceLocation-type-type"), std::string::npos) << Read("validation");
  EXPECT_TRUE(ReportHas("\"planted_error_result\": \"XR_ERROR_VALIDATION_FAILURE\""));
}

TEST_F(ScriptTest, ProbeReportsMissingPenAndBadOptions) {
  EXPECT_EQ(RunProbe("--hand right --seconds 0.2 --expect-pen --quiet"), 3);
  EXPECT_NE(Read("output").find("no interaction profile became current"), std::string::npos) << Read("output");
  EXPECT_TRUE(ReportHas("\"profile\": null"));
  EXPECT_TRUE(ReportHas("\"first_valid_s\": null"));
  EXPECT_EQ(RunProbe("--hand middle"), 2);
  EXPECT_EQ(RunProbe("--seconds"), 2);
}

// It exits when the runtime requires it, not when its 60 s are over.
TEST_F(ScriptTest, ProbeExitsOnLossAndExitRequest) {
  constexpr long kOneSecond = 90;
  Script("0.2 lose_session\n");
  EXPECT_EQ(RunProbe("--hand left --seconds 60 --quiet"), 0);
  EXPECT_LT(Frames(), kOneSecond);
  Script("0.2 lose_instance\n");
  EXPECT_EQ(RunProbe("--hand left --seconds 60 --quiet"), 0);
  EXPECT_LT(Frames(), kOneSecond);
  Script("0.2 exit\n");
  EXPECT_EQ(RunProbe("--hand left --seconds 60 --quiet"), 0);
  EXPECT_LT(Frames(), kOneSecond);
  EXPECT_TRUE(ReportHas("\"errors\": []")) << Read("report.json");
}

}  // namespace test_script
}  // namespace omni::runtime
