// What each component of a profile reads at a sync: from the service's inputs, or from conformance automation.
#pragma once

#include <string>
#include <unordered_map>
#include <vector>

#include "layer/src/actions/profile.h"
#include "service/protocol/state_memory.h"

namespace omni::layer {

using protocol::InputValue;

// What XR_EXT_conformance_automation has set for a hand (layer/src/actions/test_device.h).
struct TestInputs {
  bool active = false;
  std::string profile;                                 // that the device claims to be
  std::unordered_map<std::string, InputValue> values;  // by local path of a scalar: "/input/thumbstick/x"
};

struct ComponentInput {
  InputValue value;
  InputValue
      click;  // what stands for the component where a boolean is asked: itself, or a click that the service makes
  bool digital = false;
};

// One per component of `profile`, in its order. `test` null: the service's.
std::vector<ComponentInput> ReadInputs(const Profile& profile, const protocol::InputSnapshot& inputs,
                                       const TestInputs* test);

}  // namespace omni::layer
