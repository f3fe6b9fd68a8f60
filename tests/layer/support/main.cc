// Points the real loader at this build tree's layer and runtime, and the layer at a socket of this process.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

// Debian's loader 1.0.20 leaks its LoaderInstance (88 bytes and what hangs on it) with every xrCreateInstance, layer or
// no layer. Leaks of the layer itself show in Lifecycle.FiftyInstancesLeakNoHandlesOrFiles.
extern "C" const char* __lsan_default_suppressions();  // NOLINT(bugprone-reserved-identifier)
extern "C" const char* __lsan_default_suppressions() { return "leak:libopenxr_loader\n"; }

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  char folder[] = "/tmp/omni_layer_test_XXXXXX";
  if (!mkdtemp(folder)) {
    std::perror("mkdtemp");
    return 1;
  }
  const std::string build = OMNI_BINARY_DIR;
  setenv("XR_RUNTIME_JSON", (build + "/share/openxr/1/omni_test_runtime.json").c_str(), 1);
  // OMNI_TEST_LAYER_PATH: another build of the layer (faults), more layers around it (stack.cc).
  const char* layers = std::getenv("OMNI_TEST_LAYER_PATH");
  setenv("XR_API_LAYER_PATH", layers ? layers : (build + "/share/openxr/1/api_layers/explicit.d").c_str(), 1);
  if (!layers) unsetenv("XR_ENABLE_API_LAYERS");
  setenv("OMNI_SOCKET", (std::string(folder) + "/omnid.sock").c_str(), 1);
  unsetenv("OMNI_HAND");
  unsetenv("OMNI_TEST_RUNTIME_SCRIPT");
  const int result = RUN_ALL_TESTS();
  std::filesystem::remove_all(folder);
  return result;
}
