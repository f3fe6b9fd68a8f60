// Joins objects where a scene has more than haptics supports. Set-up only.
#pragma once

#include <cstddef>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

// The first so many objects are left as they are when there are more than haptics::kMaxObjects.
inline constexpr std::size_t kKeptApart = haptics::kMaxObjects - 8;

// Appends `part` to `whole`; texture coordinates that only one of them has are "not a number" for the other, which
// means: no texture there.
void JoinTo(haptics::InputObject part, haptics::InputObject& whole);

// At most haptics::kMaxObjects remain: the first ones, then one of each kind (double-sided, car wall, kinematic) that
// holds the rest. False: there was nothing to do.
bool JoinBeyondLimit(std::vector<haptics::InputObject>& objects);

}  // namespace omni::scene
