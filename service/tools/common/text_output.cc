#include "service/tools/common/text_output.h"

#include <iostream>

#include "service/console/wrap.h"

namespace omni::tools {

void Print(const std::string& text) { std::cout << console::ForPeople(text); }

}  // namespace omni::tools
