#include "service/sim/twin/recording.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <string>
#include <string_view>
#include <utility>

#include "service/base/files/whole_file.h"

namespace omni::sim {
namespace {

constexpr std::size_t kRowsPerWake = 50;  // who reads the record as it grows is 50 ms late

// Calls visit(name, direction, unit, value) for every column in order: the one list of columns.
template <class Visit>
void VisitColumns(const TruthRow& row, Visit&& visit) {
  const auto vector = [&](std::string_view name, const base::Vec3& v, std::string_view unit) {
    visit(name, "_x", unit, v.x);
    visit(name, "_y", unit, v.y);
    visit(name, "_z", unit, v.z);
  };
  visit("t_ns", "", "", row.t_ns);
  visit("present", "", "", std::int64_t{row.present});
  vector("magnet", row.magnet_m, "_m");
  vector("axis", row.axis, "");
  vector("tip", row.tip_m, "_m");
  vector("velocity", row.velocity_m_s, "_m_s");
  vector("current", row.current_A, "_A");
  vector("set_point", row.set_point_A, "_A");
  vector("temperature", row.temperature_C, "_C");
  vector("force", row.force_N, "_N");
  vector("coil_force", row.coil_force_N, "_N");
  visit("gap", "", "_m", row.gap_m);
  visit("command_age", "", "_s", row.command_age_s);
  visit("faults", "", "", std::int64_t{row.faults});
}

template <class Number>
void Append(std::string& text, Number value) {
  char digits[40];
  const std::to_chars_result end = std::to_chars(digits, digits + sizeof digits, value);
  text.append(digits, end.ptr);
}

void AppendRow(std::string& text, const TruthRow& row) {
  bool first = true;
  VisitColumns(row, [&](std::string_view, std::string_view, std::string_view, auto value) {
    if (!first) text += ',';
    first = false;
    Append(text, value);
  });
  text += '\n';
}

}  // namespace

std::string TruthHeader() {
  std::string header;
  VisitColumns(TruthRow{}, [&](std::string_view name, std::string_view direction, std::string_view unit, auto) {
    if (!header.empty()) header += ',';
    header.append(name).append(direction).append(unit);
  });
  return header;
}

base::Result<std::unique_ptr<Recording>> Recording::Open(const std::string& path) {
  base::Result<base::UniqueFd> file = base::MakeNewFile(path);
  if (!file.ok()) return base::Error{file.error()};
  return std::unique_ptr<Recording>(new Recording(std::move(*file), path));
}

Recording::Recording(base::UniqueFd file, std::string path) : file_(std::move(file)), path_(std::move(path)) {
  queue_.reserve(kQueueMax);
  thread_ = std::thread([this] { Run(); });
}

Recording::~Recording() {
  {
    const std::lock_guard lock(mutex_);
    closing_ = true;
  }
  wake_.notify_all();
  thread_.join();
  if (lost_rows_ > 0) {
    std::fprintf(stderr, "%s: recording is incomplete, %llu rows lost: %s: free some space and run again\n",
                 path_.c_str(), static_cast<unsigned long long>(lost_rows_), std::strerror(error_));
  }
}

void Recording::Add(const TruthRow& row) {
  std::unique_lock lock(mutex_);
  wake_.wait(lock, [this] { return queue_.size() < kQueueMax; });
  queue_.push_back(row);
  if (queue_.size() == kRowsPerWake || queue_.size() == kQueueMax) wake_.notify_all();
}

void Recording::Run() {
  std::string text = TruthHeader() + "\n";
  std::vector<TruthRow> rows;
  rows.reserve(kQueueMax);
  for (bool closing = false; !closing;) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, std::chrono::milliseconds(250),
                     [this] { return closing_ || queue_.size() >= kRowsPerWake; });
      closing = closing_;
      rows.swap(queue_);
    }
    wake_.notify_all();
    if (error_ == 0) {
      for (const TruthRow& row : rows) AppendRow(text, row);
    }
    if (error_ != 0 || !Write(text)) lost_rows_ += rows.size();
    text.clear();
    rows.clear();
  }
}

bool Recording::Write(const std::string& text) noexcept {
  std::size_t done = 0;
  while (done < text.size()) {
    const ssize_t written = write(file_.get(), text.data() + done, text.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) {
      error_ = written < 0 ? errno : EIO;
      return false;
    }
    done += static_cast<std::size_t>(written);
  }
  return true;
}

}  // namespace omni::sim
