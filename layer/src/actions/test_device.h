// A pen that a conformance test moves (XR_EXT_conformance_automation), in test mode only. It replaces the service: its
// samples come from a state memory like the service's, so everything behind it works unchanged.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

#include "layer/src/actions/pen.h"
#include "layer/src/spaces/pose_math.h"
#include "service/base/sealed_memory.h"
#include "service/client/state_reader.h"

namespace omni::layer {

// What XR_EXT_conformance_automation has set for a hand.
struct TestInputs {
  bool active = false;
  std::string profile;                                 // that the device claims to be
  std::unordered_map<std::string, InputValue> values;  // by local path of a scalar: "/input/thumbstick/x"
};

class TestDevice {
 public:
  // OMNI_TEST_MODE=1: only then is the extension available.
  static bool IsEnabled();

  // Throws std::runtime_error: no memory of that kind.
  TestDevice();
  TestDevice(const TestDevice&) = delete;
  TestDevice& operator=(const TestDevice&) = delete;

  // A test has made a call: from then on the hardware is ignored.
  bool in_control() const;
  std::shared_ptr<const client::StateReader> reader() const { return reader_; }
  TestInputs inputs() const;

  void SetActive(const std::string& profile, bool active);
  // `path`: local, of a scalar component. Times are now.
  void SetValue(const std::string& path, float value);
  void SetPose(const Pose& X_BT);

  // A sample of now, so that the pen does not count as lost. Any thread; no allocation.
  void RefreshSample() noexcept;

 private:
  void Publish() noexcept;  // mutex_ held

  base::Mapping mapping_;
  protocol::StateMemory* memory_ = nullptr;  // in it
  std::shared_ptr<const client::StateReader> reader_;
  mutable std::mutex mutex_;
  bool in_control_ = false;
  TestInputs inputs_;
  Pose X_BT_{{0, 0, 0.06}, {1, 0, 0, 0}};
  std::uint64_t published_ = 0;
};

}  // namespace omni::layer
