// service/page/src/contract.ts: channels, flags and faults that the service sends, as types.
#pragma once

#include <string>

namespace omni::monitor {

std::string ContractText();

}  // namespace omni::monitor
