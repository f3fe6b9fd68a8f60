#pragma once
// An ordinary OpenXR application without graphics: instance, session, events, and one pass of input per frame.

#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

#include <atomic>
#include <string>

#include "tests/probe/bindings.h"
#include "tests/probe/options.h"
#include "tests/probe/report.h"

namespace probe {

class App {
 public:
  App(const Options& options, Report* report) : options_(options), report_(*report) {}
  ~App();
  App(const App&) = delete;
  App& operator=(const App&) = delete;

  // Instance, session, actions, spaces. False: said on stderr and recorded.
  bool Start();
  // Until the time is over, the runtime ends the session, or `stop` is set.
  void Run(const std::atomic<bool>& stop);

 private:
  // start.cc
  bool CreateInstance();
  bool CreateSession();
  bool CreateInput();
  bool CreateSpaces();
  void PlantError();
  bool HasExtension(const char* name) const;

  // frame.cc
  XrTime Now();
  void PollEvents();
  void OnStateChanged(XrSessionState state);
  void ReadProfile();
  void Frame(double time_s);
  void ReadPose(double time_s);
  void ReadButtons();
  void Pulse();
  void PrintPose(const char* name, const XrSpaceLocation& location, const XrSpaceVelocity& velocity);

  // True on success (XR_SESSION_NOT_FOCUSED and the like included); else the call is recorded, and the loop left when
  // instance or session are gone.
  bool Check(XrResult result, const char* call);
  template <class State, class Function>
  State Get(XrAction action, XrStructureType type, Function function, const char* call);
  std::string Name(XrResult result) const;

  const Options& options_;
  Report& report_;
  std::string hand_path_;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  XrSession session_ = XR_NULL_HANDLE;
  XrPath hand_ = XR_NULL_PATH;
  Actions actions_;
  XrSpace local_ = XR_NULL_HANDLE;
  XrSpace grip_ = XR_NULL_HANDLE;
  XrSpace aim_ = XR_NULL_HANDLE;
  XrSpace tip_ = XR_NULL_HANDLE;
  PFN_xrConvertTimespecTimeToTimeKHR to_time_ = nullptr;
  bool running_ = false;  // between xrBeginSession and xrEndSession
  bool done_ = false;     // session over, or lost
  bool exit_requested_ = false;
  bool select_ = false;
  XrPath profile_ = XR_NULL_PATH;
};

}  // namespace probe
