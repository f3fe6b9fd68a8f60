// What the steps of omni setup share: where their files go, the commands that they run, omnid, and the person's
// answers.
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

// A program of ours beside this one, with this terminal. It gets SIGTERM and is waited for at the end.
class SetupChild {
 public:
  static base::Result<SetupChild> Start(const std::string& program, const std::vector<std::string>& words,
                                        const std::string& log);
  SetupChild(SetupChild&& other) noexcept;
  SetupChild& operator=(SetupChild&& other) noexcept;
  ~SetupChild();
  // Its exit status, once it has ended; 128 + signal.
  std::optional<int> Poll();
  int Wait();

 private:
  explicit SetupChild(pid_t pid) : pid_(pid) {}
  void End() noexcept;
  pid_t pid_ = -1;
  std::optional<int> status_;
};

class SetupRun {
 public:
  // A rehearsal: the digital twin instead of a base, and all files in a folder of its own, which ends with it: nothing
  // of the user's is read or changed. `yes`: every question is answered with yes.
  static base::Result<std::unique_ptr<SetupRun>> Start(bool rehearsal, bool yes);
  ~SetupRun();
  SetupRun(const SetupRun&) = delete;
  SetupRun& operator=(const SetupRun&) = delete;

  bool rehearsal() const { return rehearsal_; }
  std::string device() const { return rehearsal_ ? "twin" : "usb"; }
  // For files of a rehearsal, and logs; only the user can enter it.
  const std::string& folder() const { return folder_; }
  std::string hand_socket() const { return folder_ + "/hand.sock"; }  // of the twin

  // False also at the end of the input.
  bool Ask(const std::string& question) const;
  // One of the answers; the first one at the end of the input, and with `yes`.
  std::string Choose(const std::string& question, const std::vector<std::string>& answers) const;

  // `omni WORDS`; its exit status.
  int Omni(const std::vector<std::string>& words) const;
  // In the background; its output goes to a file of folder().
  base::Result<SetupChild> OmniBehind(const std::vector<std::string>& words) const;

  // An omnid with a device: the one that runs, else one of our own until the end.
  base::Status NeedService();
  // Of our own, so that it reads changed files; one that was running before is not ours to end.
  void EndService() { service_.reset(); }

 private:
  SetupRun(bool rehearsal, bool yes, std::string folder)
      : rehearsal_(rehearsal), yes_(yes), folder_(std::move(folder)) {}

  bool rehearsal_, yes_;
  std::string folder_;
  std::optional<SetupChild> service_;
};

}  // namespace omni::tools
