// What `omni align` says.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/tools/align/align_session.h"

namespace omni::tools {

// What the person is to do now, one line.
std::string AlignStepText(const AlignSession& session);
// The placement and what it is worth.
std::string AlignOutcomeText(const AlignOptions& options, const alignment::Outcome& outcome);
// "excellent", "good", "fair" or "poor", by the expected error.
std::string AlignQualityWord(double expected_error_m);
// STAGE, LOCAL_FLOOR, LOCAL, or the number.
std::string SpaceName(int space);
// "N  runtime / system in SPACE: ..." a line each, from /alignments of a status.
std::string StoredAlignmentsText(const nlohmann::json& status);

}  // namespace omni::tools
