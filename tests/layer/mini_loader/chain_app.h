// An application over a MiniLoader: one instance, one focused session, a pose, a float and a vibration for both hands
// of the Touch profile. Several can be alive at once, over the same or different chains.
#pragma once

#include <string>
#include <vector>

#include "tests/layer/mini_loader/mini_loader.h"
#include "tests/layer/support/fake_service.h"

namespace omni::test {

struct ChainOptions {
  XrVersion api_version = XR_MAKE_VERSION(1, 0, 20);
  std::vector<const char*> extensions = {"XR_MND_headless", "XR_KHR_convert_timespec_time"};
  bool begin = true;  // suggest, attach, begin and poll until focused
};

XrInstanceCreateInfo InstanceInfo(const ChainOptions& options);

class ChainApp {
 public:
  explicit ChainApp(const MiniLoader& loader, const ChainOptions& options = {});  // throws where a step fails
  ~ChainApp();
  ChainApp(const ChainApp&) = delete;
  ChainApp& operator=(const ChainApp&) = delete;

  XrPath Path(const std::string& text) const;
  std::string Text(XrPath path) const;
  XrResult Suggest(const char* profile, const std::vector<XrActionSuggestedBinding>& bindings) const;
  XrResult Sync() const;
  void Poll();
  std::string Profile(XrPath hand) const;
  float Force(XrPath hand) const;
  XrSpaceLocation Locate(XrSpace space, XrSpace base, XrTime time) const;
  XrSpace ActionSpace(XrPath hand) const;
  XrSpace Local() const;
  // Keeps the pen alive and syncs until the right hand has this profile, for some seconds at most.
  bool WaitProfile(FakeService& service, const std::string& profile) const;

  Functions f;
  XrInstance instance = XR_NULL_HANDLE;
  XrSystemId system = XR_NULL_SYSTEM_ID;
  XrSession session = XR_NULL_HANDLE;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  XrPath left = XR_NULL_PATH;
  XrPath right = XR_NULL_PATH;
  XrActionSet set = XR_NULL_HANDLE;
  XrAction pose = XR_NULL_HANDLE;
  XrAction force = XR_NULL_HANDLE;
  XrAction haptic = XR_NULL_HANDLE;
  std::vector<XrStructureType> events;

 private:
  XrAction MakeAction(const char* name, XrActionType type) const;
  void Begin();
};

}  // namespace omni::test
