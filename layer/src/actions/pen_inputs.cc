#include "layer/src/actions/pen_inputs.h"

namespace omni::layer {
namespace {

ComponentInput FromPen(const Component& component, const protocol::InputSnapshot& inputs) {
  const auto input = [&inputs](int source) {
    return source == kNoSource ? InputValue() : inputs.components[static_cast<std::size_t>(source)];
  };
  const bool has_click = component.click_source != kNoSource;
  return {input(component.source), input(has_click ? component.click_source : component.source),
          has_click || component.type == ComponentType::kBoolean};
}

ComponentInput FromTest(const Component& component, const TestInputs& test) {
  const auto found = test.values.find(component.path);
  const InputValue value = found == test.values.end() ? InputValue() : found->second;
  return {value, value, component.type == ComponentType::kBoolean};
}

}  // namespace

std::vector<ComponentInput> ReadInputs(const Profile& profile, const protocol::InputSnapshot& inputs,
                                       const TestInputs* test) {
  std::vector<ComponentInput> out;
  out.reserve(profile.components.size());
  for (const Component& component : profile.components)
    out.push_back(test ? FromTest(component, *test) : FromPen(component, inputs));
  return out;
}

}  // namespace omni::layer
