// Names of runtimes, and the part of them that an update does not change.
#include "service/config/runtime_identity.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>

namespace omni::config {
namespace test_config_runtime_identity {

// Left: XrInstanceProperties::runtimeName as it was seen in logs and sources.
TEST(ConfigRuntimeIdentity, RemovesVendorAndVersion) {
  const std::pair<const char*, const char*> kNames[] = {
      {"Monado(XRT) by Collabora et al", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al.", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al '21.0.0-123-gabcdef'", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al 'v25.1.0'", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al '5976596'", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al 'GIT-NOTFOUND'", "Monado(XRT)"},
      {"Monado(XRT) by Collabora et al ''", "Monado(XRT)"},
      {"Pico(XRT) by Pico et al 'de86b93'", "Pico(XRT)"},
      {"XCR: Capture and Replay 'v25.0.0-411-g0a1b2c3-dirty'", "XCR: Capture and Replay"},
      {"WiVRn 'v26.9'", "WiVRn"},
      {"WiVRn", "WiVRn"},
      {"SteamVR/OpenXR", "SteamVR/OpenXR"},
      {"SteamVR/OpenXR 2.17.8", "SteamVR/OpenXR"},
      {"SteamVR/OpenXR : lighthouse", "SteamVR/OpenXR : lighthouse"},
      {"Oculus", "Oculus"},
      {"Varjo OpenXR Runtime", "Varjo OpenXR Runtime"},
      {"Varjo OpenXR Runtime 4.14.0", "Varjo OpenXR Runtime"},
      {"Windows Mixed Reality Runtime", "Windows Mixed Reality Runtime"},
      {"VIVE WAVE", "VIVE WAVE"},
      {"Pimax OpenXR", "Pimax OpenXR"},
      {"VirtualDesktopXR (Bundled)", "VirtualDesktopXR (Bundled)"},
      {"VirtualDesktopXR (1.34.6), v3", "VirtualDesktopXR"},
      {"Omni test runtime", "Omni test runtime"},
  };
  for (const auto& [name, identity] : kNames) EXPECT_EQ(RuntimeIdentity(name), identity);
}

// Digits that belong to a name, quotation marks within words, words of hexadecimal letters.
TEST(ConfigRuntimeIdentity, KeepsWordsThatAreNotVersions) {
  for (const char* name : {"PICO 4", "Quest 3S", "Focus3", "XR-4", "Jane's runtime", "Runtime effaced", "3D Vision",
                           "OpenXR-2 Runtime", "Vive 2Pro", "by Somebody"}) {
    EXPECT_EQ(RuntimeIdentity(name), name);
  }
}

TEST(ConfigRuntimeIdentity, NameOfOnlyVersionsIsKept) {
  for (const char* name : {"", "'v25.1.0'", "2.17.8", " by "}) EXPECT_EQ(RuntimeIdentity(name), name);
  EXPECT_NE(RuntimeIdentity("1.0"), RuntimeIdentity("2.0"));
}

TEST(ConfigRuntimeIdentity, IsIdempotent) {
  for (const char* name : {"Monado(XRT) by Collabora et al '5976596'", "A  B 1.2 -", "a, 1.0", "x by y by z"}) {
    const std::string identity = RuntimeIdentity(name);
    EXPECT_EQ(RuntimeIdentity(identity), identity) << name;
  }
}

}  // namespace test_config_runtime_identity
}  // namespace omni::config
