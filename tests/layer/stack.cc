// Our layer among Debian's: the tests of this program run once more as applications of their own, with LunarG's
// core_validation or api_dump above and below us. Above us, it checks what we return to the application; below us, it
// checks our calls, which must not contain anything of our own extensions.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "service/base/sanitized.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_stack {

namespace fs = std::filesystem;

const std::string kDebianLayers = "/usr/share/openxr/1/api_layers/explicit.d";
const std::string kValidation = "XR_APILAYER_LUNARG_core_validation";
const std::string kDump = "XR_APILAYER_LUNARG_api_dump";

// Tests that are valid applications of OpenXR 1.0.20, without deliberate errors.
const std::string kValidApplications =
    "States.PensClickDrivesBooleanTriggerAction:States.PressBetweenSyncsIsOnePressedSync:States."
    "ChangeReportsPhysicalTimeOfThePress:"
    "States.AnalogThresholdHasHysteresis:States.ThumbstickParentPathYieldsVector:States.NullPathMergesPenAndRuntime:"
    "States.PenSuppressesRuntimeControllerOfSameHand:States.ActionsWithoutSubactionPathsReceivePenInput:"
    "States.StatesAreInactiveWithoutFocus:States.HigherPrioritySetTakesTheSource:States.PenReturnsAfterServiceRestart:"
    "Profiles.TouchIsPreferredToSimple:Profiles.SimpleBecomesCurrentWhenSuggestedAlone:Profiles."
    "ProfileChangesOnlyInSyncWithOneEvent:"
    "Profiles.EventWhenThePenComesLater:Profiles.NoEventWhenProfileStaysTheSame:"
    "Spaces.PastPosesAreInterpolatedWithin2um:Spaces.VelocityOfOffsetSpaceIncludesLeverArm:Spaces."
    "VelocityIsRelativeToMovingBase:"
    "Spaces.LocatingInPenSpaceIsTheInverse:Spaces.TwoPenSpacesAreRigidlyJoined:Spaces.LocatableOnlyWhileItsSetIsActive:"
    "Spaces.SpaceOutlivesItsAction:"
    "Spaces.NullPathSpaceSticksToItsFirstDevice:Lifecycle.ServiceReceivesApplicationNameAndSessionStates:"
    "Lifecycle.HapticsReachTheService:StatesRules.EqualPrioritySetsShareTheSource";
const int kValidCount = 27;
// One of an extension that only we know.
const std::string kOwnExtension = "Profiles.BestSuggestedProfileBecomesCurrent";

enum class Place { kAbove, kBelow };

struct Ran {
  int status = -1;
  std::string output;
  std::string report;  // the file that the other layer wrote; empty: none
};

std::string ReadAll(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Stack : public testing::Test {
 protected:
  void SetUp() override {
    if (base::kSanitized) GTEST_SKIP() << "Debian's layers are not instrumented";
    folder_ = fs::path(std::getenv("OMNI_SOCKET")).parent_path() / "stack";
    fs::create_directories(folder_);
  }

  static bool Installed(const std::string& layer) {
    if (!fs::is_directory(kDebianLayers)) return false;
    for (const auto& entry : fs::directory_iterator(kDebianLayers))
      if (ReadAll(entry.path()).find(layer) != std::string::npos) return true;
    return false;
  }

  // This program's `tests` as another process, with `layer` in that place.
  Ran Run(const std::string& layer, Place place, const std::string& tests) const {
    const fs::path report = folder_ / "report.txt";
    fs::remove(report);
    std::string order = kLayer;
    order = place == Place::kAbove ? layer + ":" + order : order + ":" + layer;
    const std::string command =
        "XR_ENABLE_API_LAYERS=" + order + " OMNI_TEST_LAYER_PATH=" + std::getenv("XR_API_LAYER_PATH") + ":" +
        kDebianLayers + " OMNI_TEST_APP_LAYERS=none XR_CORE_VALIDATION_EXPORT_TYPE=text " +
        "XR_CORE_VALIDATION_FILE_NAME=" + report.string() + " XR_API_DUMP_EXPORT_TYPE=text " +
        "XR_API_DUMP_FILE_NAME=" + report.string() + " '" + fs::read_symlink("/proc/self/exe").string() +
        "' --gtest_filter='" + tests + "' --gtest_also_run_disabled_tests 2>&1";
    Ran ran;
    std::FILE* pipe = popen(command.c_str(), "r");
    if (!pipe) return ran;
    char part[4096];
    for (std::size_t size = 0; (size = std::fread(part, 1, sizeof(part), pipe)) > 0;) ran.output.append(part, size);
    const int status = pclose(pipe);
    ran.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    ran.report = ReadAll(report);
    return ran;
  }

  void ExpectNothingFound(Place place) const {
    const Ran ran = Run(kValidation, place, kValidApplications);
    EXPECT_EQ(ran.status, 0) << ran.output;
    EXPECT_NE(ran.output.find("Core Validation output type: text"), std::string::npos) << "it was not loaded";
    EXPECT_NE(ran.output.find("[  PASSED  ] " + std::to_string(kValidCount)), std::string::npos) << ran.output;
    EXPECT_EQ(ran.report, "") << "what it found";
  }

  fs::path folder_;
};

#define OMNI_NEEDS(layer, package) \
  if (!Installed(layer)) GTEST_SKIP() << "not installed: " package " (scripts/setup all installs it)"

TEST_F(Stack, CoreValidationAboveFindsNothing) {
  OMNI_NEEDS(kValidation, "openxr-layer-corevalidation");
  ExpectNothingFound(Place::kAbove);
}

TEST_F(Stack, CoreValidationBelowFindsNothing) {
  OMNI_NEEDS(kValidation, "openxr-layer-corevalidation");
  ExpectNothingFound(Place::kBelow);
}

// Extensions that only we know are not passed down.
TEST_F(Stack, OwnExtensionsAreStrippedBelow) {
  OMNI_NEEDS(kValidation, "openxr-layer-corevalidation");
  const Ran ran = Run(kValidation, Place::kBelow, kOwnExtension);
  EXPECT_EQ(ran.status, 0) << ran.output;
  EXPECT_NE(ran.output.find("Core Validation output type: text"), std::string::npos);
  EXPECT_EQ(ran.report, "");
}

// The tests above can fail: a planted error is found in either place.
TEST_F(Stack, CoreValidationFindsPlantedError) {
  OMNI_NEEDS(kValidation, "openxr-layer-corevalidation");
  for (const Place place : {Place::kAbove, Place::kBelow}) {
    const Ran ran = Run(kValidation, place, "StackChild.DISABLED_PlantsAnError");
    EXPECT_EQ(ran.status, 0) << ran.output;
    EXPECT_NE(ran.report.find("VUID-XrSpaceLocation-type-type"), std::string::npos) << ran.output << ran.report;
  }
}

TEST_F(Stack, WorksAboveAndBelowApiDump) {
  OMNI_NEEDS(kDump, "openxr-layer-apidump");
  const Ran above = Run(kDump, Place::kAbove, kValidApplications + ":" + kOwnExtension);
  EXPECT_EQ(above.status, 0) << above.output;
  EXPECT_NE(above.report.find("xrSyncActions"), std::string::npos);
  const Ran below = Run(kDump, Place::kBelow, kValidApplications + ":" + kOwnExtension);
  EXPECT_EQ(below.status, 0) << below.output;
  EXPECT_NE(below.report.find("xrSyncActions"), std::string::npos);
  EXPECT_EQ(below.report.find("OMNIX1"), std::string::npos) << "our extensions are stripped";
}

// Run by the test of the planted error in a process of its own.
TEST(StackChild, DISABLED_PlantsAnError) {
  omni_test_reset();
  const App app;
  const XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  XrSpaceLocation wrong{XR_TYPE_SPACE_VELOCITY};
  EXPECT_EQ(xrLocateSpace(local, local, Now_ns() + kRuntimeOffset_ns, &wrong), XR_ERROR_VALIDATION_FAILURE);
}

}  // namespace test_stack
}  // namespace omni::test
