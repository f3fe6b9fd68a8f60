// The twin's own record of the truth, one CSV row per device tick. Rows are handed to a thread that formats and writes
// them, so that a slow or full disk never delays a device tick. A full disk ends the recording, not the twin.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "service/base/result.h"
#include "service/base/unique_fd.h"
#include "service/base/vec.h"

namespace omni::sim {

struct TruthRow {
  std::int64_t t_ns = 0;
  bool present = false;
  base::Vec3 magnet_m;
  base::Vec3 axis;
  base::Vec3 tip_m;
  base::Vec3 velocity_m_s;
  base::Vec3 current_A;
  base::Vec3 set_point_A;
  base::Vec3 temperature_C;
  base::Vec3 force_N;       // magnetic force on the tool: coils + core
  base::Vec3 coil_force_N;  // of the coils alone: what is rendered
  double gap_m = 0;
  double command_age_s = 0;  // since the last valid command; before the first: since the start
  std::uint32_t faults = 0;
};

class Recording {
 public:
  // A new file (base::MakeNewFile).
  static base::Result<std::unique_ptr<Recording>> Open(const std::string& path);
  ~Recording();  // writes what is queued; says once on stderr when rows were lost
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  void Add(const TruthRow& row);

 private:
  Recording(base::UniqueFd file, std::string path);
  void Run();
  bool Write(const std::string& text) noexcept;

  static constexpr std::size_t kQueueMax = 1U << 13;  // rows; full: Add waits for the writer
  base::UniqueFd file_;
  std::string path_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<TruthRow> queue_;
  bool closing_ = false;
  std::uint64_t lost_rows_ = 0;  // writer thread only, until it has ended
  int error_ = 0;                // errno of the first failed write
  std::thread thread_;
};

// The header line, without its newline.
std::string TruthHeader();

}  // namespace omni::sim
