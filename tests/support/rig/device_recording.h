// Device recordings for tests: made with the digital twin, and parsed again.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "service/device/recording/device_recorder.h"
#include "service/sim/twin/twin.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::support {

// The twin in virtual time, recorded into `path`.
inline std::unique_ptr<device::RecordingTransport> RecordedTwin(const std::string& path, double duration_s) {
  auto twin = sim::MakeVirtualTwin(NominalDevice(), HoldingTwin({0.01, 0, 0.05}), duration_s);
  auto recorder =
      device::DeviceRecorder::Open(path, device::DescribeForRecording(twin->info(), NominalDevice().current_max_A));
  if (!recorder.ok()) return nullptr;
  return std::make_unique<device::RecordingTransport>(std::move(twin), std::move(*recorder));
}

// Records `ticks` scans, with a command after each. Returns the scans as read.
inline std::vector<base::HallScan> RecordTwin(const std::string& path, int ticks) {
  std::vector<base::HallScan> scans;
  const auto link = RecordedTwin(path, 1e-3 * ticks);
  base::HallScan scan;
  while (link != nullptr && link->Read(scan, 0) == device::ReadStatus::kScan) {
    scans.push_back(scan);
    EXPECT_TRUE(link->Write({{0.25, -0.5, 1e-3 * static_cast<double>(scans.size())}}));
  }
  return scans;
}

using FileBytes = std::vector<char>;

inline FileBytes ReadBytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void WriteBytes(const std::string& path, const FileBytes& bytes) {
  std::filesystem::remove(path);  // some file systems flush a file that is truncated and written again
  std::ofstream file(path, std::ios::binary);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace omni::support
