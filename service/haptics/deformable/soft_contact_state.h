// A place on a soft body, and what the tick remembers of one that is touched: soft_contact.h.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"
#include "service/haptics/deformable/capacitance.h"
#include "service/haptics/deformable/local_model.h"

namespace omni::haptics {

inline constexpr std::uint32_t kNoSoftTriangle = 0xFFFFFFFF;

// A place on the coarse surface of a soft body.
struct SoftPlace {
  std::uint32_t triangle = kNoSoftTriangle;
  double weights[3]{};  // barycentric, >= 0, sum 1
};

// Of one ball; slot k belongs to contact k for as long as it touches.
struct SoftSlot {
  bool active = false;
  SoftPlace place;  // where the row of the matrix was taken
  double elastic_N = 0;
  double relaxing_N = 0;
  double dent_m = 0;
  double carried_m = 0;  // displacement of the body under this ball, without the dent
  base::Vec3 point_base_m, normal;
  LocalModel model;
};

// All that changes. Zero-initialised: nothing touched.
struct SoftContactState {
  std::array<SoftSlot, kMaxSoftContacts> slots;
  ContactMatrix matrix{};
  ActiveFactor factor;
};
static_assert(std::is_trivially_copyable_v<SoftContactState>);

}  // namespace omni::haptics
