#include "tests/bench/openxr/layer_stage.h"

#include <nlohmann/json.hpp>

#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "service/tools/scene/scene.h"

namespace omni::bench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBenchedLayer = "XR_APILAYER_OMNI_stylus";
constexpr std::uint64_t kCountedTimes = 1000;

}  // namespace

base::Result<std::unique_ptr<LayerStage>> LayerStage::Open(std::uint64_t seed) {
  std::unique_ptr<LayerStage> stage(new LayerStage);
  stage->build_ = fs::read_symlink("/proc/self/exe").parent_path().parent_path();
  stage->work_ = stage->owned_.path();
  if (stage->work_.empty()) return base::Error{"no temporary folder can be made"};
  std::error_code error;
  fs::create_directory(stage->work_ / "run", error);
  fs::permissions(stage->work_ / "run", fs::perms::owner_all, error);
  if (const base::Status done = stage->Calibrate(seed); !done.ok()) return base::Error{done.error()};
  auto service =
      test::ChildProcess::Start({(stage->build_ / "bin/omnid").string(), "--device", "twin", "--twin-seed",
                                 std::to_string(seed), "--calibration", stage->calibration(), "--twin-script",
                                 tools::FindHandScript(tools::ShippedScene("extrusion")), "--log-level", "error"},
                                stage->MakeEnvironment(false));
  if (!service.ok()) return base::Error{service.error()};
  stage->service_.emplace(std::move(*service));
  return stage;
}

// As a person does once.
base::Status LayerStage::Calibrate(std::uint64_t seed) const {
  auto calibrating = test::ChildProcess::Start({(build_ / "bin/omni").string(), "calibrate", "--device", "twin",
                                                "--seed", std::to_string(seed), "-o", calibration()},
                                               {}, (work_ / "calibration.txt").string());
  if (!calibrating.ok()) return base::Error{calibrating.error()};
  if (calibrating->Wait() != 0) return base::Error{"omni calibrate failed"};
  return base::Ok{};
}

test::Environment LayerStage::MakeEnvironment(bool layer) const {
  // Without the layer also where it is enabled for all applications.
  return {std::string("DISABLE_XR_APILAYER_OMNI_stylus_1=") + (layer ? "" : "1"), "OMNI_SOCKET=" + socket_path(),
          "XR_RUNTIME_JSON=" + (build_ / "share/openxr/1/omni_test_runtime.json").string(),
          "XR_API_LAYER_PATH=" + (build_ / "share/openxr/1/api_layers/explicit.d").string(),
          std::string("XR_ENABLE_API_LAYERS=") + (layer ? kBenchedLayer : "")};
}

base::Result<nlohmann::ordered_json> LayerStage::Run(const std::vector<std::string>& arguments, bool layer) const {
  const fs::path output = work_ / "calls.json";
  std::vector<std::string> words{Program()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  if (layer) words.emplace_back("--pen");
  auto child = test::ChildProcess::Start(words, MakeEnvironment(layer), output.string());
  if (!child.ok()) return base::Error{child.error()};
  const int status = child->Wait();
  if (status != 0) return base::Error{"omni_bench_layer ended with status " + std::to_string(status)};
  const base::Result<std::string> printed = tools::ReadJsonFile(output.string(), tools::kRowsJson);
  if (!printed.ok()) return base::Error{"omni_bench_layer wrote no JSON: " + printed.error()};
  return nlohmann::ordered_json::parse(*printed);
}

base::Result<std::vector<double>> LayerStage::CountSystemCallsOfCalls() const {
  auto counts =
      test::CountSystemCalls({Program(), "--pen", "--count", std::to_string(kCountedTimes)}, MakeEnvironment(true));
  if (!counts.ok()) return base::Error{counts.error()};
  std::vector<double> each;
  for (const std::uint64_t count : *counts)
    each.push_back(static_cast<double>(count) / static_cast<double>(kCountedTimes));
  if (each.size() < std::size(kCountedCalls)) return base::Error{"omni_bench_layer counted fewer calls than it should"};
  return each;
}

}  // namespace omni::bench
