// Texts of `omni align`.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/tools/align/align_session.h"

namespace omni::tools {

// Instruction for the current step, one line.
std::string AlignStepText(const AlignSession& session);
// The placement and its accuracy.
std::string AlignOutcomeText(const AlignOptions& options, const alignment::Outcome& outcome);
// "excellent", "good", "fair" or "poor", by the expected error.
std::string AlignQualityWord(double expected_error_m);
// STAGE, LOCAL_FLOOR, LOCAL, or the number.
std::string SpaceName(int space);
// "N  runtime / system in SPACE: ..." one line each, from /alignments of a status.
std::string StoredAlignmentsText(const nlohmann::json& status);

}  // namespace omni::tools
