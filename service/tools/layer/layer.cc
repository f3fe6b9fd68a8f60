// omni layer enable, disable, status: whether applications without any knowledge of Omni get the pen.
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/doctor/elf_file.h"
#include "service/tools/layer/layer_store.h"

namespace omni::tools {
namespace {

struct LayerArguments {
  bool user = false;
  bool system = false;
  bool as_json = false;
  bool binary = false;

  LayerScope scope() const { return system ? LayerScope::kSystem : LayerScope::kUser; }
};

constexpr const char* kEnableCommand = "omni layer enable";
constexpr const char* kDisableCommand = "omni layer disable";
constexpr const char* kStatusCommand = "omni layer status";

int Enable(const LayerArguments& arguments) {
  const Surroundings surroundings = SurroundingsOfThisProcess({});
  const auto enabled = EnableLayer(surroundings, arguments.scope());
  if (!enabled.ok()) return Fail(kEnableCommand, enabled.error());
  const LayerManifest manifest = ReadLayerManifest(enabled->file, true);
  Print((enabled->replaced ? "replaced " : "wrote ") + enabled->file.string() + "\nevery OpenXR application of " +
        (arguments.system ? "this machine" : "this user") + " loads " + manifest.library +
        "\nto exclude one application, start it with " + manifest.disable_environment + "=1\n");
  for (const auto& loader : LoadersOf32Bit(surroundings)) {
    Print("warning: " + loader.string() +
          " is there for 32-bit applications, which do not start with this layer: start them with " +
          manifest.disable_environment + "=1\n");
  }
  return kExitOk;
}

int Disable(const LayerArguments& arguments) {
  const Surroundings surroundings = SurroundingsOfThisProcess({});
  const auto removed = DisableLayer(surroundings, arguments.scope());
  if (!removed.ok()) return Fail(kDisableCommand, removed.error());
  for (const auto& file : *removed) Print("removed " + file.string() + "\n");
  if (removed->empty()) Print("it was not enabled there\n");
  const Finding left = CheckEnabledLayers(surroundings);
  if (left.verdict == Verdict::kOk) Print("still enabled: " + left.what + "\n");
  return kExitOk;
}

nlohmann::ordered_json StatusJson(const Surroundings& surroundings) {
  nlohmann::ordered_json manifests = nlohmann::ordered_json::array();
  for (const LayerManifest& manifest : FindLayerManifests(surroundings)) {
    if (!IsOurs(manifest)) continue;
    manifests.push_back({{"file", manifest.file.string()},
                         {"implicit", manifest.implicit},
                         {"library", manifest.library},
                         {"problem", manifest.problem},
                         {"disable_environment", manifest.disable_environment}});
  }
  const Finding enabled = CheckEnabledLayers(surroundings);
  return {{"layer", kLayerName},
          {"enabled", enabled.verdict == Verdict::kOk},
          {"why", enabled.what},
          {"fix", enabled.fix},
          {"manifests", manifests}};
}

nlohmann::ordered_json BinaryJson(const std::string& library, const ElfFile& elf) {
  return {{"library", library},        {"bytes", elf.bytes},   {"architecture", elf.architecture()},
          {"glibc", elf.newest_glibc}, {"needed", elf.needed}, {"exported", elf.exported}};
}

std::string LayerStatusText(const nlohmann::ordered_json& status) {
  std::string text = "layer        " + status["layer"].get<std::string>() + "\n";
  text += std::string("enabled      ") + (status["enabled"].get<bool>() ? "yes: " : "no: ") +
          status["why"].get<std::string>() + "\n";
  for (const auto& manifest : status["manifests"]) {
    const std::string problem = manifest["problem"];
    text += (manifest["implicit"].get<bool>() ? "implicit     " : "explicit     ") +
            manifest["file"].get<std::string>() + " -> " +
            (problem.empty() ? manifest["library"].get<std::string>() : "skipped: " + problem) + "\n";
  }
  if (const std::string fix = status["fix"]; !fix.empty()) text += "to enable it " + fix + "\n";
  return text;
}

int Status(const LayerArguments& arguments) {
  const Surroundings surroundings = SurroundingsOfThisProcess({});
  nlohmann::ordered_json status = StatusJson(surroundings);
  std::string binary;
  if (arguments.binary) {
    const auto layer = FindInstalledLayer(surroundings);
    if (!layer.ok()) return FailWith(arguments.as_json, kStatusCommand, layer.error());
    const auto elf = ReadElfFile(layer->library);
    if (!elf.ok()) return FailWith(arguments.as_json, kStatusCommand, elf.error());
    status["binary"] = BinaryJson(layer->library, *elf);
    binary = "library      " + layer->library + "\n" + DescribeElf(*elf);
  }
  if (arguments.as_json) {
    PrintJson(status);
  } else {
    Print(LayerStatusText(status) + binary);
  }
  return kExitOk;
}

void AddScope(Command& sub, const std::shared_ptr<LayerArguments>& arguments) {
  Option user = sub.Add("--user", arguments->user, "for this user only (the default)");
  sub.Add("--system", arguments->system, "for all users of this machine; needs root").Excludes(user);
}

}  // namespace

void AddLayer(Command& app) {
  auto arguments = std::make_shared<LayerArguments>();
  Command layer = app.AddCommand("layer", "enable the OpenXR layer for all applications, or disable it");
  layer.RequireCommand();
  Command enable = layer.AddCommand("enable", "give every OpenXR application the pen (by an implicit manifest)");
  AddScope(enable, arguments);
  enable.SetAction(arguments, Enable);
  Command disable = layer.AddCommand("disable", "give the pen only to applications that name the layer");
  AddScope(disable, arguments);
  disable.SetAction(arguments, Disable);
  Command status = layer.AddCommand("status", "show the layer's manifests and whether applications get the layer");
  status.Add("--json", arguments->as_json, "as JSON");
  status.Add("--binary", arguments->binary, "describe the library too: size, C library needed, exports");
  status.SetAction(arguments, Status);
}

}  // namespace omni::tools
