// Scenes and soft bodies are built by a process for each, the program omni-builder: it has no more memory than its
// build was granted, may do nothing but build (service/builder/confine.h), and is killed when its build is cancelled.
// Nothing of what it says is trusted.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/daemon/scenes/build_way.h"

namespace omni::daemon {

class ChildBuilder final : public BuildWay {
 public:
  // `program`: the path of omni-builder.
  explicit ChildBuilder(std::string program) : program_(std::move(program)) {}

  // Whether it could be started; says what to do otherwise.
  base::Status CheckProgram() const;

  base::Result<haptics::Scene> BuildScene(const std::string& file, const scene::LoadOptions& options,
                                          const scene::LoadSteps& steps, const CancelEvent& cancel,
                                          scene::LoadReport& load, haptics::BuildReport& report) const override;
  base::Result<haptics::SoftBody> BuildSoftBody(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                                const CancelEvent& cancel,
                                                haptics::SoftBuildReport& report) const override;

 private:
  const std::string program_;
};

}  // namespace omni::daemon
