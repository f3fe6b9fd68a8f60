// Cost of one document: read by a command, and by a service while another application draws.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "service/client/connection.h"
#include "tests/support/process/child_process.h"

namespace omni::bombs {

struct Cost {
  double seconds = 0;
  double memory_MB = 0;  // peak
  std::string end;       // "refused", "loaded", "SIGABRT", "> 20 s"
};

// `words`: a program and its arguments. Killed after `limit_s`.
Cost RunCommand(const std::vector<std::string>& words, double limit_s);

// omnid on the twin, in its own folder.
class Omnid {
 public:
  Omnid(std::string program, std::string folder) : program_(std::move(program)), folder_(std::move(folder)) {}
  ~Omnid() { Kill(); }
  Omnid(const Omnid&) = delete;
  Omnid& operator=(const Omnid&) = delete;

  // With the folder's config/omni as the user's. False: it did not answer within 10 s.
  bool Start();
  bool Lives();
  void Kill();
  const std::string& end() const { return end_; }  // if it has ended: "SIGSEGV", "exit 1"

  std::string socket_path() const { return folder_ + "/run/omnid.sock"; }
  std::string config_folder() const { return folder_ + "/config/omni"; }

  void ForgetPeak() const;  // of its memory
  double PeakMemory_MB() const;
  pid_t pid() const { return pid_; }

 private:
  std::string program_, folder_;
  pid_t pid_ = -1;
  std::string end_;
};

// An application that draws changes 90 times a second, in its own thread.
class Artist {
 public:
  Artist(const std::string& socket_path, const std::string& name);
  ~Artist();
  Artist(const Artist&) = delete;
  Artist& operator=(const Artist&) = delete;

  std::uint64_t frames() const { return frames_; }  // new ones that it saw
  double LongestPause_ms();                         // between two of them, since the last call

 private:
  void Run();

  client::Connection connection_;
  std::atomic<bool> stop_ = false;
  std::atomic<std::uint64_t> frames_ = 0;
  std::atomic<std::int64_t> last_ns_ = 0, pause_ns_ = 0;
  std::thread thread_;
};

// A scene that apps.d names for `application`, until the service has loaded it or reports that it cannot.
Cost LoadByEntry(Omnid& omnid, const std::string& application, double limit_s);

// The same for a document that the application sends.
Cost LoadByDocument(Omnid& omnid, const std::string& application, const std::string& document, double limit_s);

}  // namespace omni::bombs
