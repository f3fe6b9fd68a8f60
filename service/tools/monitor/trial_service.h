// omnid with the digital twin, for omni try: a service of its own, that ends with this process.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>

#include "service/base/result.h"

namespace omni::tools {

class TrialService {
 public:
  // Makes a folder that only the user can enter, and starts omnid on a socket in it.
  static base::Result<std::unique_ptr<TrialService>> Start();
  // Ends omnid, waits for it and removes the folder.
  ~TrialService();
  TrialService(const TrialService&) = delete;
  TrialService& operator=(const TrialService&) = delete;

  const std::string& folder() const { return folder_; }
  std::string socket() const { return folder_ + "/omnid.sock"; }
  std::string hand() const { return folder_ + "/hand.sock"; }

  // Empty while omnid runs; else how it ended, with the last line of its log.
  std::string EndReason();

 private:
  TrialService(std::string folder) : folder_(std::move(folder)) {}
  base::Status Spawn();

  std::string folder_;
  pid_t pid_ = -1;
  std::string ended_;
};

// The calibration of the digital twin's base of seed 1 that Omni ships (manifests/device). Empty: there is none.
std::string TwinCalibration();

}  // namespace omni::tools
