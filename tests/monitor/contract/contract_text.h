// What the service and its page agree on: channels, flags, limits, faults, and the layout of binary messages.
#pragma once

#include <string>

namespace omni::monitor {

std::string ContractTypes();  // service/page/src/contract.ts
std::string ContractJson();   // docs/protocol/page.json

}  // namespace omni::monitor
