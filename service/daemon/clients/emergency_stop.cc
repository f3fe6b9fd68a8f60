#include "service/daemon/clients/emergency_stop.h"

#include <ctime>
#include <exception>
#include <optional>
#include <utility>

#include "service/protocol/text.h"

namespace omni::daemon {
namespace {

constexpr const char* kUnknown = "someone";

// What the writer's thread does: `by` and `at` in two lines, or nothing to remove the latch.
base::Status Apply(const std::string& path, const std::string& text) {
  if (text.empty()) return config::RemoveStop(path);
  const std::size_t end = text.find('\n');
  return config::KeepStop(path, {.by = text.substr(0, end), .at = text.substr(end + 1)});
}

}  // namespace

EmergencyStop::EmergencyStop(std::string path) : writer_(Apply) {
  state_.file = std::move(path);
  const std::optional<config::StopRecord> found = config::FindStop(state_.file);
  if (!found) return;
  state_.on = state_.from_before = true;
  state_.by = found->by.empty() ? kUnknown : protocol::Printable(found->by);
  state_.at = protocol::Printable(found->at);
  state_.latch = Latch::kKept;
}

std::string EmergencyStop::Problem() const {
  const bool failed = state_.latch == Latch::kFailed;
  if (!state_.on) return failed ? "emergency stop: the next omnid starts stopped: " + state_.problem : std::string();
  std::string text = "emergency stop, by " + state_.by + " at " + state_.at;
  if (state_.from_before) text += ", before this omnid started";
  text += ": no force until it is released (omni stop --release)";
  if (failed) text += "; it is forgotten when omnid ends: " + state_.problem;
  return text;
}

void EmergencyStop::Press(const std::string& who) {
  state_.on = true;
  state_.from_before = false;
  state_.by = who.empty() ? kUnknown : who;
  state_.at = config::IsoTime(static_cast<std::int64_t>(std::time(nullptr)));
  Request();
}

void EmergencyStop::Release() {
  state_.on = false;
  Request();
}

void EmergencyStop::Request() {
  state_.latch = Latch::kPending;
  state_.problem.clear();
  if (state_.file.empty()) {
    state_.latch = state_.on ? Latch::kFailed : Latch::kNone;
    if (state_.on) state_.problem = "there is no folder for its file; set HOME or XDG_STATE_HOME";
    return;
  }
  try {
    requested_ = writer_.RequestWrite(state_.file, state_.on ? state_.by + "\n" + state_.at : std::string());
  } catch (const std::exception& caught) {  // no memory, no thread
    Settle(base::Error{state_.file + ": cannot be written: " + caught.what()});
  }
}

void EmergencyStop::Settle(const base::Status& status) {
  state_.problem = status.ok() ? std::string() : status.error();
  state_.latch = !status.ok() ? Latch::kFailed : state_.on ? Latch::kKept : Latch::kNone;
}

std::string EmergencyStop::Poll(std::int64_t now_ns) {
  const State before = state_;
  while (const std::optional<FileWriter::Written> written = writer_.PopWritten()) {
    written_ = written->number;
    if (written_ == requested_) Settle(written->status);
  }
  const std::string news = state_.problem == before.problem ? ""
                           : state_.problem.empty()         ? "kept in " + state_.file
                                                            : state_.problem;
  if (!state_.on || written_ != requested_ || now_ns - checked_ns_ < kCheckEvery_ns) return news;
  checked_ns_ = now_ns;
  const State settled = state_;
  Request();
  if (state_.latch == Latch::kPending) state_ = settled;  // until there is another result
  return news;
}

}  // namespace omni::daemon
