#include "service/tools/monitor/monitor.h"

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <thread>

#include "service/base/clock.h"
#include "service/base/files/whole_file.h"
#include "service/monitor/page/channels.h"
#include "service/tools/common/terminal.h"

namespace omni::tools {
namespace {

constexpr auto kPause = std::chrono::milliseconds(20);

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, CloseFile>;

// The rows of one omnid after another, as they are published.
class TickRows {
 public:
  explicit TickRows(std::FILE* file) : file_(file) {}

  void WriteHeader() const {
    std::fputs("time_s", file_);
    for (const monitor::Channel& channel : monitor::Channels()) std::fprintf(file_, ",%s", channel.name);
    std::fputs(",t_monotonic_s\n", file_);
  }

  // `state` may be null.
  void WriteNew(const std::shared_ptr<const client::StateReader>& state) {
    if (state == nullptr) return;
    const std::uint64_t end = state->published();
    if (state != state_ || next_ > end) next_ = end;
    state_ = state;
    for (; next_ < end; ++next_) {
      protocol::ToolSample sample;
      protocol::TelemetrySample telemetry;
      if (state->ReadAt(next_, sample, telemetry)) {
        Write(sample, telemetry);
      } else {
        ++count_.lost;
      }
    }
  }

  TelemetryCount count() const { return count_; }

 private:
  void Write(const protocol::ToolSample& sample, const protocol::TelemetrySample& telemetry) {
    const double t_s = 1e-9 * static_cast<double>(sample.t_ns);
    if (!start_s_) start_s_ = t_s;
    std::fprintf(file_, "%.6f", t_s - *start_s_);
    for (const monitor::Channel& channel : monitor::Channels()) {
      std::fprintf(file_, ",%.9g", static_cast<double>(channel.value(sample, telemetry)));
    }
    std::fprintf(file_, ",%.6f\n", t_s);
    ++count_.rows;
  }

  std::FILE* file_;
  std::shared_ptr<const client::StateReader> state_;
  std::uint64_t next_ = 0;  // publication of state_
  std::optional<double> start_s_;
  TelemetryCount count_;
};

}  // namespace

base::Result<TelemetryCount> WriteTelemetry(client::Connection& connection, const std::string& path, double seconds) {
  const File file(std::fopen(path.c_str(), "wxe"));
  if (file == nullptr && errno == EEXIST) {
    return base::Error{path + ": already exists; choose another name, or remove it"};
  }
  if (file == nullptr) return base::Error{base::WriteProblem(path, errno)};
  TickRows rows(file.get());
  rows.WriteHeader();
  const std::int64_t start_ns = base::MonotonicNow_ns();
  for (std::int64_t now_ns = start_ns; static_cast<double>(now_ns - start_ns) * 1e-9 < seconds;
       now_ns = base::MonotonicNow_ns()) {
    if (EndSignals::asked()) break;
    connection.Poll(now_ns);
    connection.SignalAlive();
    rows.WriteNew(connection.state());
    if (std::fflush(file.get()) != 0) return base::Error{base::WriteProblem(path, errno)};
    std::this_thread::sleep_for(kPause);
  }
  return rows.count();
}

}  // namespace omni::tools
