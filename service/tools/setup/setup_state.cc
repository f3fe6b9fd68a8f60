#include "service/tools/setup/setup.h"

#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/config/files/alignment_file.h"
#include "service/config/paths.h"
#include "service/device/usb/usb_bus.h"
#include "service/tools/common/output.h"
#include "service/tools/doctor/openxr_manifests.h"

namespace omni::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

StepState Known(bool done, std::string text) {
  return {done ? StepState::Kind::kDone : StepState::Kind::kOpen, std::move(text)};
}

bool IsThere(const fs::path& path) {
  std::error_code error;
  return !path.empty() && fs::exists(path, error);
}

}  // namespace

base::Result<std::string> FindUsbBase() {
  const auto bus = device::MakeUsbBus(false);
  if (!bus.ok()) return base::Error{bus.error()};
  const base::Result<std::vector<device::UsbBase>> bases = (*bus)->ListBases();
  if (!bases.ok()) return base::Error{bases.error()};
  if (bases->empty()) {
    return base::Error{
        "no base is on USB. Connect it and switch its supply on; without a base, `omni setup --rehearse` shows the "
        "steps on a simulated one"};
  }
  const device::UsbBase& first = bases->front();
  if (!first.problem.empty()) {
    const fs::path rule = fs::path(config::ShareFolder() + "/../lib/udev/rules.d/70-omni.rules").lexically_normal();
    return base::Error{first.problem + ". As root, once:\n    install -m 644 " +
                       (IsThere(rule) ? rule.string() : "manifests/udev/70-omni.rules") +
                       " /etc/udev/rules.d/\n    udevadm control --reload\n    udevadm trigger --subsystem-match=usb"};
  }
  const std::string many = bases->size() > 1 ? ", and " + std::to_string(bases->size() - 1) + " more" : "";
  return "base " + first.serial + " on USB port " + first.port + many;
}

Inputs WhoseInputs(const std::string& path) {
  std::ifstream in(path);
  std::string first;
  if (!std::getline(in, first)) return Inputs::kNone;
  return first == kWrittenBySetup ? Inputs::kOfSetup : Inputs::kOfTheUser;
}

StepState DeviceState(const json& status) {
  if (const std::string name = base::StringAt(status, "/device/name"); !name.empty()) {
    const bool simulated = !base::StringAt(status, "/SIMULATION").empty();
    return Known(true, "omnid has the device " + name + (simulated ? ", a simulation" : ""));
  }
  const base::Result<std::string> found = FindUsbBase();
  return Known(found.ok(), found.ok() ? *found : found.error());
}

StepState CalibrationState(const json& status) {
  if (const std::string why = base::StringAt(status, "/calibration_refused"); !why.empty()) return Known(false, why);
  if (const std::string date = base::StringAt(status, "/calibration/date"); !date.empty()) {
    const std::string what = "of " + date.substr(0, 10) + ", serial " + base::StringAt(status, "/calibration/serial");
    return Known(true, (TrueAt(status, "/calibration/shipped") ? "shipped with the twin, " : "") + what);
  }
  const std::string file = config::UserCalibrationFile();
  if (status.is_null() && IsThere(file)) return Known(true, file);
  return Known(false, "never calibrated: the nominal geometry is used, with less force");
}

StepState AlignmentState(const json& /*status*/) {
  const base::Result<config::AlignmentFile> file = config::LoadAlignmentFile(config::UserAlignmentFile());
  if (!file.ok()) return Known(false, file.error());
  if (file->entries.empty()) return Known(false, "no headset is aligned: the base is assumed in front of the person");
  for (const config::AlignmentEntry& entry : file->entries) {
    if (entry.IsTrusted()) return Known(true, entry.system + ", " + entry.date.substr(0, 10));
  }
  return Known(false, "the headset's space or the base has moved since: align again");
}

StepState InputsState(const json& /*status*/) {
  const std::string file = config::UserInputsFile();
  const bool written = WhoseInputs(file) != Inputs::kNone;
  return Known(written, written ? file : "right hand, usual pressure");
}

StepState LayerState(const json& /*status*/) {
  const Finding enabled = CheckEnabledLayers(SurroundingsOfThisProcess({}));
  return Known(enabled.verdict == Verdict::kOk, enabled.what);
}

StepState StartState(const json& /*status*/) {
  constexpr const char* kWanted = "systemd/user/sockets.target.wants/omnid.socket";
  const fs::path settings = fs::path(config::UserInputsFile()).parent_path().parent_path();
  std::error_code error;
  const bool wanted = fs::is_symlink(settings / kWanted, error) || fs::is_symlink(fs::path("/etc") / kWanted, error);
  return Known(wanted, wanted ? "omnid starts with the first application" : "omnid is started by hand");
}

}  // namespace omni::tools
