#include "service/daemon/scenes/build_way.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cerrno>
#include <new>

namespace omni::daemon {

CancelEvent::CancelEvent() noexcept : event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

void CancelEvent::Set() noexcept {
  set_.store(true);
  const std::uint64_t one = 1;
  while (write(event_.get(), &one, sizeof one) < 0 && errno == EINTR) {
  }
}

base::Result<haptics::Scene> BuildHere::BuildScene(const std::string& file, const scene::LoadOptions& options,
                                                   const scene::LoadSteps& steps, const CancelEvent& cancel,
                                                   scene::LoadReport& load, haptics::BuildReport& report) const {
  const base::WorkWatch watch([&] { return cancel.is_set(); });
  scene::LoadOptions watched = options;
  watched.watch = &watch;
  try {
    return scene::LoadInSteps(file, watched, steps, load, report);
  } catch (const std::bad_alloc&) {
    return base::Error{file + ": does not fit into memory; simplify the model"};
  }
}

base::Result<haptics::SoftBody> BuildHere::BuildSoftBody(const haptics::Mesh& mesh,
                                                         const haptics::SoftBodyOptions& options,
                                                         const CancelEvent& cancel,
                                                         haptics::SoftBuildReport& report) const {
  haptics::SoftBodyOptions watched = options;
  watched.progress = [&](double done) { return !cancel.is_set() && (!options.progress || options.progress(done)); };
  return scene::BuildSoftBodyHere(mesh, watched, report);
}

}  // namespace omni::daemon
