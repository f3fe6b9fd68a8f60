// The part of an OpenXR runtime's name that updates of the runtime do not change.
#pragma once

#include <string>
#include <string_view>

namespace omni::config {

// XrInstanceProperties::runtimeName without what changes from build to build: an alignment belongs to the runtime, not
// to one build of it. Monado, and its derivatives, put `git describe` into the name, in quotation marks.
//
//   1. From the first quotation mark (' or ") at the start of a word everything goes.
//   2. From " by " on everything goes: the vendor.
//   3. Words that are versions go: 2.17.8, v25, v25.1.0-7-g1234567, (1.34.6); so do git hashes of 7 to 40 digits.
//   4. Spaces become single; spaces, commas, colons, semicolons and dashes at the end go.
//
// If nothing is left, the name is its own identity.
std::string RuntimeIdentity(std::string_view runtime_name);

}  // namespace omni::config
