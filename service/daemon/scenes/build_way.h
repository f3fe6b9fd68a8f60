// How scenes and soft bodies are built: in this process, for tests, or by a process for each (child_builder.h).
#pragma once

#include <atomic>
#include <string>

#include "service/base/unique_fd.h"
#include "service/haptics/geometry/mesh.h"
#include "service/haptics/scene/scene.h"
#include "service/scene/load_scene.h"

namespace omni::daemon {

// Ends a build from any thread.
class CancelEvent {
 public:
  CancelEvent() noexcept;
  void Set() noexcept;
  bool is_set() const noexcept { return set_.load(); }
  // Readable once it is set; < 0 when this process has no descriptor left: it is noticed later then.
  int fd() const noexcept { return event_.get(); }

 private:
  std::atomic<bool> set_{false};
  base::UniqueFd event_;
};

// Several threads use it at once; a call returns when its build has ended or is cancelled, with an error then.
class BuildWay {
 public:
  virtual ~BuildWay() = default;

  // `file` is its name in messages; options.memory is the document, options.beside what is beside it.
  virtual base::Result<haptics::Scene> BuildScene(const std::string& file, const scene::LoadOptions& options,
                                                  const scene::LoadSteps& steps, const CancelEvent& cancel,
                                                  scene::LoadReport& load, haptics::BuildReport& report) const = 0;
  // options.progress is called, too.
  virtual base::Result<haptics::SoftBody> BuildSoftBody(const haptics::Mesh& mesh,
                                                        const haptics::SoftBodyOptions& options,
                                                        const CancelEvent& cancel,
                                                        haptics::SoftBuildReport& report) const = 0;
};

class BuildHere final : public BuildWay {
 public:
  base::Result<haptics::Scene> BuildScene(const std::string& file, const scene::LoadOptions& options,
                                          const scene::LoadSteps& steps, const CancelEvent& cancel,
                                          scene::LoadReport& load, haptics::BuildReport& report) const override;
  base::Result<haptics::SoftBody> BuildSoftBody(const haptics::Mesh& mesh, const haptics::SoftBodyOptions& options,
                                                const CancelEvent& cancel,
                                                haptics::SoftBuildReport& report) const override;
};

}  // namespace omni::daemon
