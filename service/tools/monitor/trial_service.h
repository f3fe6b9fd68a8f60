// omnid with the digital twin, for omni try: a service of its own, that ends with this process.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "service/base/result.h"
#include "service/tools/common/child_program.h"

namespace omni::tools {

class TrialService {
 public:
  // Starts omnid on a socket in a folder that only the user can enter. `twin_record`: a CSV file of the twin's truth;
  // empty: none.
  static base::Result<std::unique_ptr<TrialService>> Start(const std::string& twin_record);

  const std::string& folder() const { return folder_.path(); }
  std::string socket() const { return folder() + kSocketName; }
  std::string hand() const { return folder() + kHandName; }

  // Empty while omnid runs; else how it ended, with the last line of its log.
  std::string EndReason();

 private:
  static constexpr const char* kSocketName = "/omnid.sock";
  static constexpr const char* kHandName = "/hand.sock";

  TrialService(PrivateFolder folder, ChildProgram omnid) : folder_(std::move(folder)), omnid_(std::move(omnid)) {}

  PrivateFolder folder_;
  ChildProgram omnid_;
};

}  // namespace omni::tools
