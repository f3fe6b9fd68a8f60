// docs/howto/engines.md: which programs, how they call, and what is tested of them. From data and scenarios alone.
#pragma once

#include <string>

namespace omni::test::patterns {

std::string Page();

}  // namespace omni::test::patterns
