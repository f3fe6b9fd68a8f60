// The latch of an emergency stop: while this file exists, omnid starts without force. That it exists is what counts;
// what it says is for people.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "service/base/result.h"

namespace omni::config {

struct StopRecord {
  std::string by;  // who pressed it, as that program calls itself; empty: not known
  std::string at;  // ISO 8601, UTC
};

// None: nothing is at that path, or it is empty. Whatever else is there counts as a latch, also if it cannot be read;
// its time is then that of the last change.
std::optional<StopRecord> FindStop(const std::string& path);

// "2026-01-31T12:00:00Z"
std::string IsoTime(std::int64_t unix_s);

// Both return when it is on the disk, and wait for it. A latch that is there already is kept as it is.
base::Status KeepStop(const std::string& path, const StopRecord& record);
base::Status RemoveStop(const std::string& path);

}  // namespace omni::config
