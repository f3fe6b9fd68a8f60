// Requests of `omni align` to omnid.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/alignment/types.h"
#include "service/base/result.h"
#include "service/client/connection.h"

namespace omni::tools {

// Waits for the answer, 2.5 s at most. A refusal is an error with omnid's text; otherwise the result is that text.
base::Result<std::string> RequestBasePose(client::Connection& connection, const protocol::BasePoseCommand& command);

struct Headset {
  std::string runtime, system;
  int space = protocol::kSpaceLocal;
};

protocol::BasePoseCommand StoreCommand(const Headset& headset, const alignment::Outcome& outcome,
                                       const std::string& method);

// One of the stored alignments by its number in `omni align --show`.
struct StoredAlignment {
  Headset headset;
  alignment::Rigid base_space;
  int samples = 0;
  double rms_m = 0;
};
// Of this headset in this space.
base::Result<StoredAlignment> AlignmentOf(const nlohmann::json& status, const Headset& headset);
// The stored placement moved so that its mark is where it was touched; its orientation is kept.
alignment::Rigid BaseAsTouched(const alignment::Rigid& stored, const base::Vec3& mark_base_m,
                               const base::Vec3& touched_space_m);
// `number` 0: the one of a connected application's headset, else the only one. Without any: the headset of a connected
// application, its base where the layer guesses it.
base::Result<StoredAlignment> ChooseAlignment(const nlohmann::json& status, int number);

}  // namespace omni::tools
