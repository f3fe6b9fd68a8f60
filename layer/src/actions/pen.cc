#include "layer/src/actions/pen.h"

#include <algorithm>
#include <cmath>

#include "layer/src/actions/test_device.h"

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

// z of the tool frame: R (0, 0, 1).
std::array<double, 3> Axis(const protocol::ToolSample& s) {
  const auto& [w, x, y, z] = s.orientation_base_wxyz;
  return {2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)};
}

double Distance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

std::int64_t LastInput_ns(const protocol::InputSnapshot& inputs) {
  std::int64_t last_ns = 0;
  for (const protocol::InputValue& input : inputs.components) last_ns = std::max(last_ns, input.t_change_ns);
  return last_ns;
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

bool PenRest::Moved(const PenSnapshot& pen, double distance_m, double angle_rad) const {
  // Chord of the angle between two unit vectors.
  return Distance(pen.sample.position_base_m, position_base_m_) > distance_m ||
         Distance(Axis(pen.sample), axis_base_) > 2 * std::sin(angle_rad / 2);
}

void PenRest::Hold(const PenSnapshot& pen) {
  still_ = false;
  held_since_ns_ = pen.sample.t_ns;
  position_base_m_ = pen.sample.position_base_m;
  axis_base_ = Axis(pen.sample);
}

bool PenRest::Update(const PenSnapshot& pen, const RestLimits& limits) {
  const std::int64_t now_ns = pen.sample.t_ns;
  const bool tracked = (pen.sample.flags & protocol::kToolTracked) != 0;
  const bool contact = (pen.sample.flags & protocol::kToolContact) != 0;
  const std::int64_t input_ns = LastInput_ns(pen.inputs);
  if (!started_) {
    started_ = true;
    last_tracked_ns_ = now_ns;
    last_input_ns_ = input_ns;
    Hold(pen);
  }
  if (tracked) last_tracked_ns_ = now_ns;
  const bool used = contact || input_ns != last_input_ns_;
  last_input_ns_ = input_ns;
  // While it lies, small motion is the table's, and its angle means nothing: it may roll.
  const bool moved = still_ ? Moved(pen, limits.taken_up_m, M_PI) : Moved(pen, limits.still_m, limits.still_rad);
  if (used || (tracked && moved)) Hold(pen);
  if (limits.still_ns > 0 && now_ns - held_since_ns_ >= limits.still_ns) still_ = true;
  const bool docked = pen.inputs.components[static_cast<std::size_t>(protocol::InputIndex::kDocked)].value > 0.5f;
  return docked || still_ || now_ns - last_tracked_ns_ >= limits.untracked_ns;
}

}  // namespace omni::layer
