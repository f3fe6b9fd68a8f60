// What only this layer has: extensions, their functions, and names of their enumerants.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "layer/src/entry/omni_openxr_compat.h"

namespace omni::layer {

// From layer/extensions.json, which the manifests are made from too.
struct OurExtension {
  const char* name;
  std::uint32_t version;
  bool may_be_below;  // requested from the runtime first; otherwise only we know it, and it is never passed down
  const char* needs;  // another one of ours that must be enabled too; null: none
};

std::span<const OurExtension> OurExtensions();

// A function of an extension that only this layer implements.
struct OwnFunction {
  const char* name;       // "xrApplyForceOMNIX1"
  const char* extension;  // answered only to applications that enabled it
  PFN_xrVoidFunction function;
};

const std::vector<OwnFunction>& OwnFunctions();
// Of them those of XR_EXT_conformance_automation: docs/howto/openxr-layer.md, "Conformance tests".
const std::vector<OwnFunction>& AutomationFunctions();

// The name of an enumerant of our extensions, which the runtime does not know; nullptr: not one of them.
const char* OwnName(XrResult value) noexcept;
const char* OwnName(XrStructureType value) noexcept;

}  // namespace omni::layer
