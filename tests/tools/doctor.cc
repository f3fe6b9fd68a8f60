// Every diagnosis on fabricated trees: its finding and its fix.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "service/tools/doctor/diagnosis.h"
#include "service/tools/doctor/elf_file.h"
#include "service/tools/doctor/openxr_manifests.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_doctor {

namespace fs = std::filesystem;

// A library that is an OpenXR layer: Debian's own validation layer.
constexpr const char* kSomeLayer = "/usr/lib/x86_64-linux-gnu/openxr/1/api_layers/libXrApiLayer_core_validation.so";

std::string Manifest(const std::string& library, const std::string& more = {}) {
  return R"({"file_format_version": "1.0.0", "api_layer": {"name": "XR_APILAYER_OMNI_stylus", "library_path": ")" +
         library + R"(", "api_version": "1.0", "implementation_version": "1", "description": "d")" + more + "}}";
}

// A machine of its own: system folders, home and environment in a temporary folder.
class Doctor : public testing::Test {
 protected:
  Doctor() {
    there_.root = folder_.Path("root");
    there_.environment = {{"HOME", folder_.Path("home")}};
    there_.socket_path = folder_.Path("run/omnid.sock");
    there_.service = {.running = false, .error = "omnid does not answer at x", .status = {}};
  }

  std::string Explicit(const std::string& content, const std::string& name = "XrApiLayer_omni.json") {
    return folder_.Write("root/usr/share/openxr/1/api_layers/explicit.d/" + name, content);
  }
  std::string Implicit(const std::string& content) {
    return folder_.Write("home/.local/share/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json", content);
  }

  void Expect(const Finding& finding, Verdict verdict, std::initializer_list<std::string> words) {
    EXPECT_EQ(finding.verdict, verdict) << finding.what;
    for (const std::string& word : words) {
      EXPECT_NE((finding.what + " | " + finding.fix).find(word), std::string::npos)
          << word << " not in: " << finding.what << " | " << finding.fix;
    }
    EXPECT_EQ(finding.fix.empty(), verdict == Verdict::kOk) << finding.fix;
  }

  test::TempFolder folder_;
  Surroundings there_;
};

TEST_F(Doctor, MissingLayerNamesSearchedFolders) {
  Expect(
      LookForLayer(there_), Verdict::kFail,
      {"XR_APILAYER_OMNI_stylus", folder_.Path("root/usr/share/openxr/1/api_layers/explicit.d"), "XR_API_LAYER_PATH"});
  Expect(CheckLayerLibrary(there_), Verdict::kFail, {"layer manifest"});
}

TEST_F(Doctor, FindsLayerInSystemAndHomeFolders) {
  const std::string file = Explicit(Manifest(kSomeLayer));
  Expect(LookForLayer(there_), Verdict::kOk, {file, "explicit"});
  fs::remove(file);
  const std::string implicit = Implicit(Manifest(kSomeLayer, R"(, "disable_environment": "NO_OMNI")"));
  Expect(LookForLayer(there_), Verdict::kOk, {implicit, "implicit"});
}

TEST_F(Doctor, LayerPathVariableReplacesExplicitFolders) {
  Explicit(Manifest(kSomeLayer));
  const std::string file = folder_.Write("build/explicit.d/XrApiLayer_omni.json", Manifest("./libx.so"));
  there_.environment["XR_API_LAYER_PATH"] = folder_.Path("nothing") + ":" + folder_.Path("build/explicit.d");
  const auto manifests = FindLayerManifests(there_);
  ASSERT_EQ(manifests.size(), 1u);
  EXPECT_EQ(manifests[0].file, file);
  EXPECT_EQ(manifests[0].library, folder_.Path("build/explicit.d/libx.so")) << "relative to the manifest";
  there_.environment["XR_API_LAYER_PATH"] = folder_.Path("nothing");
  Expect(LookForLayer(there_), Verdict::kFail, {folder_.Path("nothing")});
}

TEST_F(Doctor, XdgVariablesReplaceTheirStandardFolders) {
  there_.environment["XDG_DATA_DIRS"] = "/a:/b";
  there_.environment["XDG_DATA_HOME"] = "/home/data";
  there_.environment["XDG_CONFIG_DIRS"] = "/c";
  const std::string below = "/openxr/1/api_layers/implicit.d";
  EXPECT_EQ(LayerFolders(there_, true), (std::vector<fs::path>{"/c" + below, there_.SystemPath("/etc" + below),
                                                               "/a" + below, "/b" + below, "/home/data" + below}));
}

TEST_F(Doctor, SaysThatDebian12HasNoRuntime) {
  EXPECT_EQ(LookForRuntime(there_).fix.find("Debian 12"), std::string::npos);
  fs::create_directories(there_.SystemPath("/etc"));
  std::ofstream(there_.SystemPath("/etc/os-release")) << "NAME=\"Debian GNU/Linux\"\nVERSION_ID=\"13\"\nID=debian\n";
  EXPECT_EQ(LookForRuntime(there_).fix.find("Debian 12"), std::string::npos);
  std::ofstream(there_.SystemPath("/etc/os-release")) << "VERSION_ID=\"12\"\nID=debian\n";
  const Finding finding = LookForRuntime(there_);
  EXPECT_EQ(finding.verdict, Verdict::kFail);
  EXPECT_NE(finding.fix.find("Debian 12 has no package of one"), std::string::npos) << finding.fix;
}

// The loader's JSON reader allows them.
TEST_F(Doctor, ReadsManifestsWithComments) {
  const std::string manifest = Manifest(kSomeLayer);
  Explicit("// made by hand\n" + manifest.substr(0, 1) + " /* \" */ // {\n" + manifest.substr(1));
  const auto manifests = FindLayerManifests(there_);
  ASSERT_EQ(manifests.size(), 1u);
  EXPECT_EQ(manifests[0].problem, "");
  Explicit("/* never closed " + manifest);
  EXPECT_NE(FindLayerManifests(there_)[0].problem, "");
}

TEST_F(Doctor, ReportsWhyTheLoaderSkipsAManifest) {
  const struct {
    std::string content;
    const char* why;
  } rows[] = {
      {"{", "not a JSON object"},
      {"[]", "not a JSON object"},
      {"", "larger than 1 MiB"},
      {R"({"file_format_version": "2.0.0", "api_layer": {}})", "file_format_version"},
      {R"({"file_format_version": "1.0.0"})", "api_layer"},
      {R"({"file_format_version": "1.0.0", "api_layer": {"name": 3}})", "name"},
      {R"({"file_format_version": "1.0.0", "api_layer": {"name": "XR_APILAYER_OMNI_stylus"}})", "library_path"},
      {R"({"file_format_version": "1.0.0", "api_layer": {"name": "n", "library_path": "l", "api_version": "2.0"}})",
       "api_version"},
      {R"({"file_format_version": "1.0.0", "api_layer": {"name": "n", "library_path": "l", "api_version": "1.0",
                   "implementation_version": "1.2"}})",
       "implementation_version"}};
  for (const auto& row : rows) {
    Explicit(row.content);
    Expect(LookForLayer(there_), Verdict::kFail, {"XrApiLayer_omni.json", row.why, "install"});
  }
}

TEST_F(Doctor, ImplicitManifestNeedsADisableVariable) {
  Implicit(Manifest(kSomeLayer));
  Expect(LookForLayer(there_), Verdict::kFail, {"disable_environment"});
}

TEST_F(Doctor, NamesDuplicateManifests) {
  Explicit(Manifest(kSomeLayer));
  Explicit(Manifest(kSomeLayer), "other.json");
  Expect(LintDuplicates(there_), Verdict::kWarn, {"XrApiLayer_omni.json", "other.json"});
}

TEST_F(Doctor, ChecksThatLibraryOpensAndExportsNegotiation) {
  Explicit(Manifest(folder_.Path("gone.so")));
  Expect(CheckLayerLibrary(there_), Verdict::kFail, {folder_.Path("gone.so"), "does not exist"});
  Explicit(Manifest(folder_.Write("text.so", "not a library")));
  Expect(CheckLayerLibrary(there_), Verdict::kFail, {"cannot be opened"});
  Explicit(Manifest("libm.so.6"));  // a bare name: dlopen searches
  Expect(CheckLayerLibrary(there_), Verdict::kFail,
         {"libm.so.6", "does not export xrNegotiateLoaderApiLayerInterface"});
  Explicit(Manifest("libm.so.6", R"(, "functions": {"xrNegotiateLoaderApiLayerInterface": "cos"})"));
  Expect(CheckLayerLibrary(there_), Verdict::kOk, {"cos"});
  Explicit(Manifest(kSomeLayer));
  Expect(CheckLayerLibrary(there_), Verdict::kOk, {kSomeLayer});
}

TEST_F(Doctor, LayerIsEnabledByXrEnableApiLayers) {
  Explicit(Manifest(kSomeLayer));
  Expect(CheckEnabledLayers(there_), Verdict::kWarn, {"not enabled", "XR_ENABLE_API_LAYERS=XR_APILAYER_OMNI_stylus"});
  there_.environment["XR_ENABLE_API_LAYERS"] = "XR_APILAYER_OMNI_stylus";
  Expect(CheckEnabledLayers(there_), Verdict::kOk, {});
}

TEST_F(Doctor, FailsWhenAnEnabledLayerIsMissing) {
  Explicit(Manifest(kSomeLayer));
  there_.environment["XR_ENABLE_API_LAYERS"] = "XR_APILAYER_OMNI_stylus:XR_APILAYER_GONE";
  Expect(LintBadInstallation(there_), Verdict::kFail, {"XR_APILAYER_GONE", "no OpenXR application starts"});
}

TEST_F(Doctor, ImplicitLayerHonoursEnableAndDisableVariables) {
  Implicit(Manifest(kSomeLayer, R"(, "disable_environment": "NO_OMNI", "enable_environment": "USE_OMNI")"));
  Expect(CheckEnabledLayers(there_), Verdict::kWarn, {"not enabled"});
  there_.environment["USE_OMNI"] = "";  // being set is enough
  Expect(CheckEnabledLayers(there_), Verdict::kOk, {"implicit"});
  there_.environment["NO_OMNI"] = "0";  // and disable wins
  Expect(CheckEnabledLayers(there_), Verdict::kWarn, {"NO_OMNI", "unset"});
}

TEST_F(Doctor, LoaderOf32BitApplicationsIsNamed) {
  Implicit(Manifest(kSomeLayer, R"(, "disable_environment": "NO_OMNI")"));
  Expect(CheckEnabledLayers(there_), Verdict::kOk, {"implicit"});
  folder_.Write("root/usr/lib/i386-linux-gnu/libopenxr_loader.so.1", "");
  Expect(CheckEnabledLayers(there_), Verdict::kWarn, {"32-bit", "i386-linux-gnu", "NO_OMNI=1"});
}

// Observed with Debian's loader 1.0.20: it searches implicit layers for such a name only if there is an explicit one.
TEST_F(Doctor, ImplicitLayerByNameNeedsAnExplicitLayer) {
  Implicit(Manifest(kSomeLayer, R"(, "disable_environment": "NO_OMNI")"));
  there_.environment["XR_ENABLE_API_LAYERS"] = "XR_APILAYER_OMNI_stylus";
  Expect(LintBadInstallation(there_), Verdict::kFail, {"XR_APILAYER_OMNI_stylus"});
  Explicit(Manifest(kSomeLayer));
  Expect(LintBadInstallation(there_), Verdict::kOk, {});
}

TEST_F(Doctor, SteamNeedsItsLaunchOptions) {
  Expect(CheckSteam(there_), Verdict::kOk, {});
  fs::create_directories(folder_.Path("home/.local/share/Steam"));
  Expect(CheckSteam(there_), Verdict::kWarn,
         {"PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS=1", "PRESSURE_VESSEL_FILESYSTEMS_RW=" + folder_.Path("run")});
  there_.environment["PRESSURE_VESSEL_IMPORT_OPENXR_1_LAYERS"] = "1";
  Expect(CheckSteam(there_), Verdict::kOk, {});
}

TEST_F(Doctor, FindsRuntimeByVariableUserThenSystem) {
  Expect(LookForRuntime(there_), Verdict::kFail, {"active_runtime.json", "XR_RUNTIME_JSON"});
  const std::string library = folder_.Write("lib/librt.so", "x");
  const std::string manifest = R"({"file_format_version": "1.0.0", "runtime": {"library_path": ")" + library + "\"}}";
  folder_.Write("root/etc/xdg/openxr/1/active_runtime.json", manifest);
  Expect(LookForRuntime(there_), Verdict::kOk, {"etc/xdg", library});
  folder_.Write("home/.config/openxr/1/active_runtime.json", R"({"runtime": {"library_path": "../librt.so"}})");
  Expect(LookForRuntime(there_), Verdict::kFail, {"home/.config/openxr/librt.so", "does not exist"});
  there_.environment["XR_RUNTIME_JSON"] = folder_.Write("rt.json", "{}");
  Expect(LookForRuntime(there_), Verdict::kFail, {"rt.json", "runtime.library_path"});
}

TEST_F(Doctor, RejectsPipesDevicesAndOversizedManifests) {
  const std::string pipe = folder_.Path("pipe.json");
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& endless : {pipe, std::string("/dev/zero")}) {
    there_.environment["XR_RUNTIME_JSON"] = endless;
    Expect(LookForRuntime(there_), Verdict::kFail, {endless, "is not a regular file"});
  }
  std::string keys = "{\"0\": 0";
  for (int i = 1; i < 2000; ++i) keys += ", \"" + std::to_string(i) + "\": 0";
  Explicit(keys + "}");
  Expect(LookForLayer(there_), Verdict::kFail, {"XrApiLayer_omni.json", "1000 members, the limit"});
}

TEST_F(Doctor, ResolvesRelativeLibraryThroughRuntimeSymlink) {
  folder_.Write("opt/rt/librt.so", "x");
  const std::string real = folder_.Write("opt/rt/rt.json", R"({"runtime": {"library_path": "./librt.so"}})");
  fs::create_directories(folder_.Path("home/.config/openxr/1"));
  fs::create_symlink(real, folder_.Path("home/.config/openxr/1/active_runtime.json"));
  Expect(LookForRuntime(there_), Verdict::kOk, {folder_.Path("opt/rt/librt.so")});
}

TEST_F(Doctor, SocketFolderMustBeOursAlone) {
  Expect(CheckSocketFolder(there_), Verdict::kOk, {"omnid creates it"});
  fs::create_directory(folder_.Path("run"));
  fs::permissions(folder_.Path("run"), fs::perms::owner_all);
  Expect(CheckSocketFolder(there_), Verdict::kOk, {folder_.Path("run")});
  fs::permissions(folder_.Path("run"), fs::perms::owner_all | fs::perms::others_exec);
  Expect(CheckSocketFolder(there_), Verdict::kFail, {"0701", "0700"});
  there_.socket_path = folder_.Path(std::string(120, 'x'));
  Expect(CheckSocketFolder(there_), Verdict::kFail, {"107", "OMNI_SOCKET"});
}

TEST_F(Doctor, ReportsServiceStoppedOutdatedOrWithProblems) {
  Expect(LookForService(there_), Verdict::kFail, {"does not answer", "omnid --device twin"});
  there_.service = {.running = true, .error = {}, .status = {{"service", {{"version", OMNI_VERSION}, {"pid", 7}}}}};
  Expect(LookForService(there_), Verdict::kOk, {"pid 7"});
  there_.service.status["problems"] = {"10-a.toml:3: scale"};
  Expect(LookForService(there_), Verdict::kWarn, {"10-a.toml:3", "omni status"});
  there_.service.status["service"]["version"] = "0.0.1";
  Expect(LookForService(there_), Verdict::kWarn, {"0.0.1", OMNI_VERSION});
}

TEST_F(Doctor, ReportsAbsentAndSimulatedDevice) {
  Expect(LookForDevice(there_), Verdict::kWarn, {"omnid does not run"});
  there_.service = {.running = true, .error = {}, .status = {{"device", {{"name", nullptr}, {"absent", "no twin"}}}}};
  Expect(LookForDevice(there_), Verdict::kFail, {"no twin"});
  there_.service.status["device"] = {{"name", "twin"}, {"simulation", true}};
  Expect(LookForDevice(there_), Verdict::kOk, {"twin", "simulation"});
}

TEST_F(Doctor, ReportsEachCalibrationState) {
  Expect(CheckCalibration(there_), Verdict::kWarn, {"omnid does not run"});
  there_.service = {.running = true, .error = {}, .status = {{"device", {{"name", nullptr}}}}};
  Expect(CheckCalibration(there_), Verdict::kWarn, {"without a device"});
  nlohmann::json& status = there_.service.status;
  status = {{"device", {{"name", "twin"}}}, {"calibration", nullptr}, {"calibration_refused", nullptr}};
  Expect(CheckCalibration(there_), Verdict::kWarn, {"never calibrated", "nominal geometry", "omni calibrate"});
  status["calibration_misfit"] = "this base was never calibrated";
  Expect(CheckCalibration(there_), Verdict::kFail, {"never calibrated", "calibrate it: omni calibrate"});
  status.erase("calibration_misfit");
  status["calibration_refused"] = "/c.toml:2: checksum";
  Expect(CheckCalibration(there_), Verdict::kWarn, {"/c.toml:2: checksum", "--replace", "--restore"});
  status["calibration_refused"] = nullptr;
  status["calibration"] = {{"file", "/c.toml"}, {"date", "2026"}, {"note", nullptr}};
  Expect(CheckCalibration(there_), Verdict::kOk, {"/c.toml of 2026"});
  status["calibration"]["shipped"] = true;
  Expect(CheckCalibration(there_), Verdict::kOk, {"shipped with the twin: /c.toml of 2026"});
  status["calibration"]["shipped"] = false;
  status["calibration"]["note"] = "without a checksum";
  Expect(CheckCalibration(there_), Verdict::kOk, {"/c.toml of 2026, without a checksum"});
  status["calibration_misfit"] = "/c.toml does not fit";
  Expect(CheckCalibration(there_), Verdict::kFail, {"does not fit", "omni calibrate --replace"});
}

TEST_F(Doctor, ListsEveryRoomFindingWithItsFix) {
  Expect(CheckRoom(there_), Verdict::kWarn, {"omnid does not run"});
  there_.service = {.running = true, .error = {}, .status = {{"device", {{"name", nullptr}}}}};
  Expect(CheckRoom(there_), Verdict::kWarn, {"without a device"});
  nlohmann::json& status = there_.service.status;
  status = {{"device", {{"name", "twin"}}}};
  Expect(CheckRoom(there_), Verdict::kOk, {"no sensor is faulty"});
  status["room"] = nlohmann::json::array();
  Expect(CheckRoom(there_), Verdict::kOk, {"no sensor is faulty"});
  status["room"] = {{{"kind", "magnet-near"}, {"what", "another magnet"}, {"fix", "take it away"}},
                    {{"kind", "sensor-silent"}, {"what", "sensor 3 gives nothing"}, {"fix", "its cable"}}};
  Expect(CheckRoom(there_), Verdict::kFail, {"another magnet; sensor 3 gives nothing", "take it away; its cable"});
}

TEST_F(Doctor, RealtimeFollowsTheServiceStatus) {
  there_.service = {
      .running = true, .error = {}, .status = {{"tick", {{"realtime", true}, {"late", 2}, {"count", 9}}}}};
  Expect(CheckRealtime(there_), Verdict::kOk, {"2 late ticks of 9"});
  there_.service.status["tick"] = {{"realtime", false}, {"realtime_reason", "SCHED_FIFO refused"}};
  Expect(CheckRealtime(there_), Verdict::kWarn, {"SCHED_FIFO refused", "limits.d", "rtkit", "systemd"});
}

TEST_F(Doctor, RealtimeIsTriedDirectlyWithoutService) {
  const Finding finding = CheckRealtime(there_);
  EXPECT_NE(finding.verdict, Verdict::kFail) << "late ticks are no reason not to work";
  EXPECT_EQ(finding.fix.empty(), finding.verdict == Verdict::kOk);
}

TEST_F(Doctor, ReportsBadApplicationFilesAndMissingScenes) {
  there_.app_folders = {folder_.Path("apps.d")};
  there_.scenes_folder = folder_.Path("scenes");
  Expect(CheckApplications(there_), Verdict::kWarn, {"no application", "apps.d"});
  const std::string file = folder_.Write("apps.d/10-a.toml", "application = \"a*\"\nscene = \"gone.glb\"\n");
  Expect(CheckApplications(there_), Verdict::kFail, {"a*", "gone.glb", file});
  folder_.Write("apps.d/20-b.toml", "application = 3\n");
  Expect(CheckApplications(there_), Verdict::kFail, {"20-b.toml", "application"});
}

TEST_F(Doctor, WarnsWhenNotAligned) {
  Expect(CheckAlignment(there_), Verdict::kWarn, {"not aligned: the base is assumed to be in front of you"});
  there_.service.status = {{"aligned", true}};
  Expect(CheckAlignment(there_), Verdict::kOk, {});
}

TEST_F(Doctor, ReportHasEveryDiagnosisOnce) {
  const std::vector<Diagnosed> findings = Diagnose(there_);
  EXPECT_EQ(findings.size(), DiagnosisTable().size());
  EXPECT_TRUE(AnyFailed(findings));
  const nlohmann::json json = DoctorJson(findings, {});
  EXPECT_EQ(json["ok"], false);
  EXPECT_EQ(json["diagnoses"].size(), findings.size());
  const std::string text = DoctorText(findings, {});
  for (const Diagnosed& row : findings) EXPECT_NE(text.find(row.name), std::string::npos) << row.name;
  EXPECT_FALSE(AnyFailed({{"a", {Verdict::kWarn, "w", "f"}}, {"b", {Verdict::kOk, "o", ""}}}));
}

TEST_F(Doctor, SimulationIsTheFirstLine) {
  const nlohmann::json status = {{"SIMULATION", "no base"}};
  EXPECT_EQ(DoctorText({{"a", {Verdict::kOk, "o", ""}}}, status).rfind("SIMULATION: no base\n", 0), 0U);
  EXPECT_EQ(DoctorJson({}, status).dump().rfind(R"({"SIMULATION":"no base")", 0), 0U);
}

}  // namespace test_tools_doctor
}  // namespace omni::tools
