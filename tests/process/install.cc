// What `cmake --install` leaves behind works where it is, in a folder with a space in its name, staged, and moved
// afterwards.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "tests/support/process/service_end.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_install {

namespace fs = std::filesystem;

const std::string kBuildTree = OMNI_BINARY_DIR;

std::string TextOf(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

struct Ran {
  int status = -1;
  std::string text;  // of both outputs
};

Ran RunShell(const TempFolder& folder, const std::string& command) {
  const std::string log = folder.Path("output");
  const int status = std::system(("{ " + command + "; } >'" + log + "' 2>&1").c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, TextOf(log)};
}

Ran Install(const TempFolder& folder, const std::string& prefix, const std::string& stage = {}) {
  return RunShell(
      folder, "DESTDIR='" + stage + "' '" + OMNI_CMAKE + "' --install '" + kBuildTree + "' --prefix '" + prefix + "'");
}

// Installed once for all tests, and moved: nothing in it may know where it was.
class Installed : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<TempFolder>();
    const Ran installed = Install(*folder_, FirstPlace());
    ASSERT_EQ(installed.status, 0) << installed.text;
    unit_ = TextOf(FirstPlace() + "/lib/systemd/user/omnid.service");
    fs::rename(FirstPlace(), Prefix());
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static std::string FirstPlace() { return folder_->Path("first place"); }
  static std::string Prefix() { return folder_->Path("moved there"); }

  // A shell command in which $P is the prefix, with a service's environment of its own.
  static Ran Run(const std::string& command) {
    return RunShell(*folder_, "export P='" + Prefix() + "' OMNI_SOCKET='" + folder_->Path("run/omnid.sock") +
                                  "' XDG_CONFIG_HOME='" + folder_->Path("config") + "' XDG_CACHE_HOME='" +
                                  folder_->Path("cache") + "' XDG_DATA_DIRS='" + Prefix() +
                                  "/share' XR_ENABLE_API_LAYERS=XR_APILAYER_OMNI_stylus XR_RUNTIME_JSON='" +
                                  kBuildTree + "/share/openxr/1/omni_test_runtime.json'; unset XR_API_LAYER_PATH; " +
                                  command);
  }

  static std::unique_ptr<TempFolder> folder_;
  static std::string unit_;
};

std::unique_ptr<TempFolder> Installed::folder_;
std::string Installed::unit_;

TEST_F(Installed, ContainsEveryFile) {
  for (const char* file : {"bin/omni",
                           "bin/omnid",
                           "bin/omni-builder",
                           "bin/omni_align_probe",
                           "bin/omni_touch",
                           "bin/omni_force",
                           "bin/omni_block",
                           "bin/scene_render",
                           "include/openxr/omni_force_feedback.h",
                           "lib/systemd/user/omnid.service",
                           "lib/systemd/user/omnid.socket",
                           "lib/udev/rules.d/70-omni.rules",
                           "share/omni/apps.d/10-extrusion.toml",
                           "share/omni/device/omni.toml",
                           "share/omni/scenes/dragon.glb",
                           "share/omni/scenes/extrusion.glb",
                           "share/omni/scenes/extrusion.hand.json",
                           "share/omni/scenes/racetrack.glb",
                           "share/doc/omni/LICENSE",
                           "share/doc/omni/CITATION.cff",
                           "share/doc/omni/notices.txt",
                           "share/doc/omni/README.md",
                           "share/doc/omni/docs/howto/install.md",
                           "share/bash-completion/completions/omni",
                           "share/fish/vendor_completions.d/omni.fish",
                           "share/zsh/vendor-completions/_omni",
                           "share/doc/libomni-dev/examples/touch/main.cc",
                           "share/doc/libomni-dev/examples/CMakeLists.txt",
                           "share/cmake/Omni/OmniConfig.cmake",
                           "share/pkgconfig/omni.pc",
                           "share/doc/omni/manifests/limits/99-omni-realtime.conf"}) {
    EXPECT_TRUE(fs::is_regular_file(fs::path(Prefix()) / file)) << file;
  }
}

TEST_F(Installed, ExamplesBuildAgainstInstalledHeaders) {
  // A compiler is none of the programs whose time is virtual here.
  const Ran built = Run(
      "unset LD_PRELOAD; CMAKE_GENERATOR=Ninja cmake -S \"$P/share/doc/libomni-dev/examples\" -B \"$P/../examples\" "
      "-DCMAKE_PREFIX_PATH=\"$P\" && cmake --build \"$P/../examples\"");
  ASSERT_EQ(built.status, 0) << built.text;
  for (const char* name : {"omni_force", "omni_block"}) {
    const Ran help = Run("\"$P/../examples/" + std::string(name) + "\" --help");
    EXPECT_EQ(help.status, 0) << help.text;
  }
  const Ran flags = Run("PKG_CONFIG_PATH=\"$P/share/pkgconfig\" pkg-config --cflags omni");
  EXPECT_EQ(flags.status, 0) << flags.text;
  EXPECT_NE(flags.text.find("/include"), std::string::npos) << flags.text;
}

// The installed documents and the files that they name.
TEST_F(Installed, DocumentsHaveNoDeadLinks) {
  std::string dead;
  const fs::path root = fs::path(Prefix()) / "share/doc/omni";
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() != ".md") continue;
    const std::string text = TextOf(entry.path());
    static const std::regex kLink(R"(\]\(([^)#:]+)(#[^)]*)?\))");
    for (std::sregex_iterator at(text.begin(), text.end(), kLink), end; at != end; ++at) {
      if (!fs::exists(entry.path().parent_path() / (*at)[1].str())) {
        dead += fs::relative(entry.path(), root).string() + ": " + (*at)[1].str() + "\n";
      }
    }
  }
  EXPECT_EQ(dead, "");
}

TEST_F(Installed, SystemdUnitStartsInstalledOmnidWithUsbBase) {
  EXPECT_NE(unit_.find("\nExecStart=\"" + FirstPlace() + "/bin/omnid\" --device usb\n"), std::string::npos) << unit_;
  EXPECT_EQ(unit_.find('@' + std::string("OMNI")), std::string::npos);
}

TEST_F(Installed, DoctorPassesWithRunningService) {
  const Ran ran =
      Run("\"$P/bin/omnid\" --device twin & service=$!; "
          "for i in $(seq 100); do \"$P/bin/omni\" status | grep SIMULATION && break; sleep 0.1; done; "
          "\"$P/bin/omni\" doctor; result=$?; kill $service; wait $service && exit $result");
  EXPECT_EQ(ran.status, 0) << ran.text;
  EXPECT_NE(ran.text.find("all scenes load"), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find("SIMULATION: "), std::string::npos) << ran.text;
  EXPECT_NE(ran.text.find(Prefix() + "/share/openxr/1/api_layers/explicit.d"), std::string::npos) << ran.text;
}

TEST_F(Installed, LayerIsEnabledAtMovedLocation) {
  const Ran ran = Run("XDG_DATA_HOME='" + folder_->Path("data") + "' \"$P/bin/omni\" layer enable --user");
  ASSERT_EQ(ran.status, 0) << ran.text;
  const auto manifest = nlohmann::json::parse(
      TextOf(folder_->Path("data/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json")), nullptr, false);
  ASSERT_TRUE(manifest.is_object());
  const std::string library = manifest["api_layer"]["library_path"];
  EXPECT_EQ(library.rfind(Prefix() + "/", 0), 0U) << library;
  EXPECT_TRUE(fs::is_regular_file(library)) << library;
}

TEST_F(Installed, DemoRunsFromMovedInstallation) {
  const Ran ran = Run("'" OMNI_SOURCE_DIR "/scripts/demo' --prefix \"$P\" --built '" + kBuildTree + "' --out '" +
                      folder_->Path("demo") + "' --ideal --scene \"$P/share/omni/scenes/extrusion.glb\"");
  EXPECT_EQ(ran.status, 0) << ran.text;
  EXPECT_NE(ran.text.find("demo: ok"), std::string::npos) << ran.text;
}

TEST_F(Installed, StagedFilesNameTheFinalPrefix) {
  const TempFolder folder;
  const Ran installed = Install(folder, "/opt/of omni", folder.Path("stage"));
  ASSERT_EQ(installed.status, 0) << installed.text;
  const std::string prefix = folder.Path("stage/opt/of omni");
  const std::string unit = TextOf(prefix + "/lib/systemd/user/omnid.service");
  EXPECT_NE(unit.find("ExecStart=\"/opt/of omni/bin/omnid\""), std::string::npos) << unit;
  const Ran explained = RunShell(folder, "'" + prefix + "/bin/omni' scene explain extrusion");
  EXPECT_EQ(explained.status, 0) << explained.text;
}

TEST_F(Installed, ServiceReportsMissingBaseAndWaits) {
  ServiceProcess service;
  service.StartProgram({Prefix() + "/bin/omnid"}, service.Path("log"));
  const Ran ran = RunShell(*folder_, "export OMNI_SOCKET='" + service.socket_path() + "'; for i in $(seq 100); do '" +
                                         Prefix() + "/bin/omni' status && break; sleep 0.1; done");
  EXPECT_NE(ran.text.find("device     none: "), std::string::npos) << ran.text;
  EXPECT_EQ(ran.text.find("SIMULATION"), std::string::npos) << ran.text;
  EXPECT_EQ(ChildOf(service.pid()), 0) << "no simulation runs";
  const ServiceEnd end = EndAndWait(service, "it waits for a base");
  EXPECT_EQ(end.status, 0);
  EXPECT_LT(end.ms, kEndsWithin_ms);
  const std::string log = TextOf(service.Path("log"));
  EXPECT_NE(log.find("omnid tries again every second"), std::string::npos) << log;
}

}  // namespace test_process_install
}  // namespace omni::test
