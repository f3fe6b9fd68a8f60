// Set-up for measuring OpenXR calls: an omnid on the twin, calibrated, in its room, and programs over the in-repo
// headless runtime, with and without the layer. All are of this build tree.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "tests/bench/harness/work_folder.h"
#include "tests/support/process/child_process.h"

namespace omni::bench {

class LayerStage {
 public:
  // Starts omnid. Error: no temporary folder, or a program is not built.
  static base::Result<std::unique_ptr<LayerStage>> Open(std::uint64_t seed);

  std::string socket_path() const { return (work_ / "run" / "omnid.sock").string(); }
  std::string runtime_library() const { return (build_ / "lib/libomni_test_runtime.so").string(); }
  std::string layer_library() const { return (build_ / "lib/libXrApiLayer_omni.so").string(); }

  // Runs omni_bench_layer with these arguments (tests/bench/layer/main.cc); the JSON that it prints.
  base::Result<nlohmann::ordered_json> Run(const std::vector<std::string>& arguments, bool layer) const;

  // System calls of its counted calls, one each on average: pen, other hand, pass-through.
  base::Result<std::vector<double>> CountSystemCallsOfCalls() const;

 private:
  LayerStage() = default;
  base::Status Calibrate(std::uint64_t seed) const;
  std::string calibration() const { return (work_ / "calibration.toml").string(); }
  test::Environment MakeEnvironment(bool layer) const;
  std::string Program() const { return (build_ / "bin/omni_bench_layer").string(); }

  WorkFolder owned_;
  std::filesystem::path build_;
  std::filesystem::path work_;
  std::optional<test::ChildProcess> service_;
};

// Names of the counted calls, in CountSystemCallsOfCalls' order.
inline constexpr const char* kCountedCalls[] = {"xrLocateSpace (pen)", "xrLocateSpace (other hand)",
                                                "xrGetInstanceProperties (pass-through)"};

}  // namespace omni::bench
