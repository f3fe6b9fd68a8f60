// What the steps of omni setup share: where their files go, the commands that they run, omnid, and the person's
// answers.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "service/base/result.h"
#include "service/tools/common/child_program.h"

namespace omni::tools {

class SetupRun {
 public:
  // A rehearsal: the digital twin instead of a base, and all files in a folder of its own, which ends with it: nothing
  // of the user's is read or changed. `yes`: every question is answered with yes.
  static base::Result<std::unique_ptr<SetupRun>> Start(bool rehearsal, bool yes);

  bool rehearsal() const { return rehearsal_; }
  std::string device() const { return rehearsal_ ? "twin" : "usb"; }
  // For files of a rehearsal, and logs; only the user can enter it.
  const std::string& folder() const { return folder_.path(); }
  std::string hand_socket() const { return folder() + "/hand.sock"; }  // of the twin

  // False also at the end of the input.
  bool Ask(const std::string& question) const;
  // One of the answers; the first one with `yes` and for an empty line; `at_end` at the end of the input.
  std::string Choose(const std::string& question, const std::vector<std::string>& answers,
                     const std::string& at_end) const;

  // `omni WORDS`; its exit status.
  int Omni(const std::vector<std::string>& words) const;
  // In the background; its output goes to a file of folder().
  base::Result<ChildProgram> OmniBehind(const std::vector<std::string>& words) const;

  // An omnid with a device: the one that runs, else one of our own until the end.
  base::Status NeedService();
  // Of our own, so that it reads changed files; one that was running before is not ours to end.
  void EndService() { service_.reset(); }

 private:
  SetupRun(bool rehearsal, bool yes, PrivateFolder folder)
      : rehearsal_(rehearsal), yes_(yes), folder_(std::move(folder)) {}

  bool rehearsal_, yes_;
  PrivateFolder folder_;
  std::optional<ChildProgram> service_;  // ends before its folder
};

}  // namespace omni::tools
