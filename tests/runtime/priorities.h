#pragma once
// XR_EXT_active_action_set_priority with the registry's values, for headers that lack it.

#include <openxr/openxr.h>

#ifndef XR_EXT_active_action_set_priority
#define XR_EXT_active_action_set_priority 1
#define XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME "XR_EXT_active_action_set_priority"
#define XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT (static_cast<XrStructureType>(1000373000))
typedef struct XrActiveActionSetPriorityEXT {
  XrActionSet actionSet;
  uint32_t priorityOverride;
} XrActiveActionSetPriorityEXT;
typedef struct XrActiveActionSetPrioritiesEXT {
  XrStructureType type;
  const void* next;
  uint32_t actionSetPriorityCount;
  const XrActiveActionSetPriorityEXT* actionSetPriorities;
} XrActiveActionSetPrioritiesEXT;
#endif
