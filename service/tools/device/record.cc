// omni record: records what a base measures, without a service and without force: the base is never armed.
#include <memory>
#include <string>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"
#include "service/config/files/device_file.h"
#include "service/daemon/devices/open_device.h"
#include "service/daemon/run.h"
#include "service/device/recording/recording_reader.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/output.h"
#include "service/tools/common/terminal.h"
#include "service/tools/recordings/report.h"

namespace omni::tools {
namespace {

constexpr std::int64_t kRecordPatience_ns = 200'000'000;  // of one Read: how soon a signal is seen

struct RecordRequest {
  daemon::RunOptions run;
  double seconds = 0;
};

int FailRecord(const std::string& why) { return Fail("omni record", why); }

// Empty, or why it ended early.
std::string ReadScans(device::Transport& transport, double seconds) {
  const EndSignals signals;
  const std::int64_t end_ns = base::MonotonicNow_ns() + static_cast<std::int64_t>(seconds * 1e9);
  base::HallScan scan;
  while (!EndSignals::asked() && (seconds == 0 || base::MonotonicNow_ns() < end_ns)) {
    const device::ReadStatus status = transport.Read(scan, kRecordPatience_ns);
    if (status == device::ReadStatus::kGone) return "the base was disconnected; the file holds what came before";
  }
  return "";
}

int RecordBase(const RecordRequest& request) {
  const std::string& path = request.run.record_device_path;
  if (daemon::IsReplay(request.run.device)) return FailRecord("--device " + request.run.device + " is a recording");
  if (const std::string problem = base::NewFileProblem(path, request.run.replace); !problem.empty()) {
    return FailRecord(problem);
  }
  if (const auto way = daemon::MakeWay(request.run); !way.ok()) return FailRecord(way.error());
  base::Result<daemon::OpenedDevice> opened = daemon::OpenDevice(request.run);
  if (!opened.ok()) return FailRecord(opened.error());
  const std::string refused = daemon::RecordDevice(request.run, config::DefaultDevice().current_max_A, *opened);
  if (!refused.empty()) return FailRecord(refused);
  const std::string ended = ReadScans(*opened->transport, request.seconds);
  device::DeviceRecorder& recorder = opened->recording->recorder();
  recorder.Close();
  if (!recorder.problem().empty()) return FailRecord(recorder.problem());
  const auto summary = device::SummariseRecording(path);
  if (!summary.ok()) return FailRecord(summary.error());
  Print(RecordingText(path, *summary));
  return ended.empty() ? kExitOk : FailRecord(ended);
}

}  // namespace

void AddRecord(Command& app) {
  auto request = std::make_shared<RecordRequest>();
  Command record = app.AddCommand(
      "record", "record what a base measures, with its coils at rest; omnid --record-device records one in use");
  record.Add("file", request->run.record_device_path, "the recording; a new file").Required();
  record.Add("--replace", request->run.replace, "replaces a file that exists");
  record.Add("--device", request->run.device, daemon::DeviceHelp())
      .Check("DEVICE", daemon::DeviceProblem)
      .ShowDefault();
  record.Add("--seconds", request->seconds, "how long (default: until Ctrl-C)").Range(0.001, 1e6);
  record.SetAction(request, RecordBase);
}

}  // namespace omni::tools
