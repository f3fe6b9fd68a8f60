// What the control core costs on a Cortex-M7: size of the image, stack, instructions of a control step. The reference
// is firmware/board/mps2_an500/budget.txt, printed by the program omni_hil_budget.
#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "service/base/result.h"

namespace omni::hil {

// Accepted ratio to the reference: allows for another compiler, not for a feature.
constexpr double kBudgetHeadRoom = 1.25;

// Name -> value, e.g. "armed_mean" -> instructions.
using Budget = std::map<std::string, std::uint32_t>;

// Runs the board through an idle and an armed session, counting. Identical everywhere for identical images.
base::Result<Budget> MeasureBudget();

base::Result<Budget> ReadBudget(const std::string& path);
std::string BudgetPage(const Budget& budget);

}  // namespace omni::hil
