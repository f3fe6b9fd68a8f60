#include "layer/src/own_names.h"

#include <cstddef>

#include "layer/include/openxr/omni_force_feedback.h"

namespace omni::layer {
namespace {

template <class T>
struct Named {
  T value;
  const char* name;
};

// A row an enumerant, extension by extension: appended here.
#define OMNI_NAMED(enumerant) \
  { enumerant, #enumerant }
constexpr Named<XrResult> kResults[] = {
    OMNI_NAMED(XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1),
    OMNI_NAMED(XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1),
};
constexpr Named<XrStructureType> kTypes[] = {
    OMNI_NAMED(XR_TYPE_SYSTEM_FORCE_FEEDBACK_PROPERTIES_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_APPLY_INFO_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1),
    OMNI_NAMED(XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_LINE_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_SPHERE_OMNIX1),
    OMNI_NAMED(XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_VISCOUS_OMNIX1),
};
#undef OMNI_NAMED

template <class T, std::size_t N>
const char* NameIn(const Named<T> (&names)[N], T value) noexcept {
  for (const Named<T>& row : names)
    if (row.value == value) return row.name;
  return nullptr;
}

}  // namespace

const char* OwnName(XrResult value) noexcept { return NameIn(kResults, value); }
const char* OwnName(XrStructureType value) noexcept { return NameIn(kTypes, value); }

}  // namespace omni::layer
