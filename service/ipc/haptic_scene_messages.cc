// An application's own scene (protocol/haptic_scene.h): from the gate to the handler.
#include <fcntl.h>
#include <sys/stat.h>

#include <utility>
#include <variant>

#include "service/ipc/control_loop.h"

namespace omni::ipc {
namespace {

// Why this is no document of `bytes` bytes that stays as it is; empty: it is one.
std::string ProblemOfDocument(int fd, std::uint64_t bytes) {
  if (fd < 0) return "HapticSceneLoad without a descriptor";
  const int needed = F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW;
  const int seals = ::fcntl(fd, F_GET_SEALS);
  if (seals < 0 || (seals & needed) != needed)
    return "HapticSceneLoad: its memory is not sealed WRITE, SHRINK and GROW";
  struct stat info {};
  if (::fstat(fd, &info) != 0 || info.st_size != static_cast<off_t>(bytes)) {
    return "HapticSceneLoad: its memory does not have the " + std::to_string(bytes) + " bytes that it says";
  }
  return {};
}

}  // namespace

bool ControlLoop::HandleHapticScene(Peer& peer, const protocol::Message& message) {
  const ClientId id = peer.id();
  const auto* load = std::get_if<protocol::HapticSceneLoad>(&message);
  const auto* end = std::get_if<protocol::HapticSceneEnd>(&message);
  const auto* place = std::get_if<protocol::HapticScenePlace>(&message);
  const auto* enable = std::get_if<protocol::HapticSceneEnable>(&message);
  const auto* nodes = std::get_if<protocol::HapticNodes>(&message);
  const auto* material = std::get_if<protocol::HapticMaterial>(&message);
  if (load == nullptr && end == nullptr && place == nullptr && enable == nullptr && nodes == nullptr &&
      material == nullptr) {
    return false;
  }
  if (peer.info().role != protocol::ClientRole::kApplication) {
    Refuse(peer, "a monitor gives no scene; say Hello as an application");
    return true;
  }
  if (load != nullptr) {
    const std::string problem = ProblemOfDocument(document_.get(), load->bytes);
    if (!problem.empty()) {
      Refuse(peer, problem);
    } else {
      Guarded("OnHapticSceneLoad", &peer, [&] { handler_.OnHapticSceneLoad(id, *load, std::move(document_)); });
    }
  } else if (end != nullptr) {
    Guarded("OnHapticSceneEnd", &peer, [&] { handler_.OnHapticSceneEnd(id, *end); });
  } else if (place != nullptr) {
    Guarded("OnHapticScenePlace", &peer, [&] { handler_.OnHapticScenePlace(id, *place); });
  } else if (enable != nullptr) {
    Guarded("OnHapticSceneEnable", &peer, [&] { handler_.OnHapticSceneEnable(id, *enable); });
  } else if (nodes != nullptr) {
    Guarded("OnHapticNodes", &peer, [&] { handler_.OnHapticNodes(id, *nodes); });
  } else {
    Guarded("OnHapticMaterial", &peer, [&] { handler_.OnHapticMaterial(id, *material); });
  }
  return true;
}

}  // namespace omni::ipc
