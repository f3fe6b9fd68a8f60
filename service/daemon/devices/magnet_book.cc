#include "service/daemon/devices/magnet_book.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <utility>

#include <spdlog/spdlog.h>

namespace omni::daemon {
namespace {

std::string DateOf(std::int64_t unix_s) {
  const auto seconds = static_cast<std::time_t>(unix_s);
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace

MagnetBook::MagnetBook(std::string path, FileWriter::Write write) : path_(std::move(path)), writer_(std::move(write)) {
  if (path_.empty()) return;
  auto loaded = config::LoadMagnetsFile(path_);
  if (loaded.ok()) {
    entries_ = std::move(*loaded);
    return;
  }
  readable_ = false;
  Drop(loaded.error() + " (not used and not overwritten): pens that were learnt are learnt again, every time",
       "correct the file or move it away, then restart omnid");
}

void MagnetBook::Drop(const std::string& what, const std::string& fix) {
  problem_ = room::RoomFinding{.kind = "magnets-file", .sensors = {}, .what = what, .fix = fix};
  spdlog::warn("magnets: {}", RoomText(*problem_));
}

void MagnetBook::LoadKnownMagnets(const std::string& serial, double calibrated_moment_Am2,
                                  tracker::MagnetOptions& options) {
  serial_ = serial;
  calibrated_moment_Am2_ = calibrated_moment_Am2;
  options_ = options;
  options.known_count = 0;
  if (!(calibrated_moment_Am2 > 0)) return;
  // The newest first; the tracker has a place for the calibrated one too.
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->base != serial || options.known_count + 1 >= tracker::kKnownMagnetsMax) continue;
    const double scale = entry->moment_Am2 / calibrated_moment_Am2;
    if (!(std::abs(scale - 1) < options.furthest)) continue;
    options.known[static_cast<std::size_t>(options.known_count++)] = {scale, scale * entry->sigma_share};
  }
}

bool MagnetBook::AddSample(const base::ToolState& tool, std::int64_t now_unix_s) {
  const bool learnt = tool.status == base::TrackingStatus::kTracking && tool.magnet == base::MagnetIdentity::kKnown &&
                      tool.moment_sigma <= options_.identified;
  if (!learnt || !readable_ || !(calibrated_moment_Am2_ > 0)) return false;
  const double moment_Am2 = tool.moment_scale * calibrated_moment_Am2_;
  const double sigma_share = tool.moment_sigma / tool.moment_scale;
  const auto is_same = [&](const config::MagnetEntry& entry) {
    const double sigma = std::hypot(sigma_share, entry.sigma_share, options_.warmth);
    return entry.base == serial_ &&
           std::abs(moment_Am2 - entry.moment_Am2) <= options_.same_sigmas * sigma * entry.moment_Am2;
  };
  if (std::any_of(entries_.begin(), entries_.end(), is_same)) return false;
  if (entries_.size() >= config::kMaxMagnets) entries_.erase(entries_.begin());
  entries_.push_back(
      {.base = serial_, .moment_Am2 = moment_Am2, .sigma_share = sigma_share, .learnt_date = DateOf(now_unix_s)});
  spdlog::info("magnets: a pen of {:.3g} A m2 is known from now on ({:.3g} of the calibrated one)", moment_Am2,
               tool.moment_scale);
  if (!path_.empty()) writer_.RequestWrite(path_, config::WriteMagnets(entries_));
  return true;
}

bool MagnetBook::HandleWritten() {
  const std::optional<room::RoomFinding> before = problem_;
  while (const std::optional<FileWriter::Written> written = writer_.PopWritten()) {
    if (written->status.ok()) {
      problem_.reset();
    } else {
      Drop(written->status.error() + ": a pen that was learnt is known until omnid ends", "make room for the file");
    }
  }
  return problem_ != before;
}

}  // namespace omni::daemon
