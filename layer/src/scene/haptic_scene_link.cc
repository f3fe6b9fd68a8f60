// Messages between the scene's record and the service: sent again after a reconnection, received at every poll; and how
// the service's parameters of a material are the application's.
#include "layer/src/scene/haptic_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <utility>

#include "service/base/clock.h"
#include "service/base/material.h"
#include "service/base/number_field.h"

namespace omni::layer {
namespace {

// The structure is its type, its chain, and a float for each live field, in their order (a test compares the names).
using Floats = std::array<float, base::kLiveMaterialFields>;
static_assert(base::FieldCount<XrHapticMaterialOMNIX1>() == 2 + base::kLiveMaterialFields,
              "XrHapticMaterialOMNIX1 has a float for each live field of service/base/material.h");
constexpr std::size_t kFloatsAt = offsetof(XrHapticMaterialOMNIX1, stiffness);

Floats FloatsOf(const XrHapticMaterialOMNIX1& material) noexcept {
  Floats floats;
  std::memcpy(floats.data(), reinterpret_cast<const std::byte*>(&material) + kFloatsAt, sizeof(floats));
  return floats;
}

XrHapticSceneStatusOMNIX1 ToStatus(protocol::HapticSceneStatus status) noexcept {
  switch (status) {
    case protocol::HapticSceneStatus::kReady:
      return XR_HAPTIC_SCENE_STATUS_READY_OMNIX1;
    case protocol::HapticSceneStatus::kFailed:
      return XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1;
    default:
      return XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1;
  }
}

}  // namespace

bool IsMaterial(const XrHapticMaterialOMNIX1& material) noexcept {
  const Floats floats = FloatsOf(material);
  return std::all_of(floats.begin(), floats.end(), [](float x) { return std::isfinite(x); });
}

base::MaterialParameters ToParameters(const XrHapticMaterialOMNIX1& material) noexcept {
  const Floats floats = FloatsOf(material);
  base::MaterialParameters given;
  for (std::size_t i = 0; i < floats.size(); ++i) given.*base::kLiveFields[i]->live = double{floats[i]};
  base::MaterialParameters parameters = base::Clamped(given);
  parameters.dynamic_friction = std::min(parameters.dynamic_friction, parameters.static_friction);
  return parameters;
}

void Put(const base::MaterialParameters& parameters, XrHapticMaterialOMNIX1& material) noexcept {
  Floats floats;
  for (std::size_t i = 0; i < floats.size(); ++i)
    floats[i] = static_cast<float>(parameters.*base::kLiveFields[i]->live);
  std::memcpy(reinterpret_cast<std::byte*>(&material) + kFloatsAt, floats.data(), sizeof(floats));
}

void HapticScenes::Poll() {
  const std::lock_guard lock(mutex_);
  if (scene_ == nullptr) return;
  HandleUpdates();
  NotifyAll();
}

void HapticScenes::SetStatus(XrHapticSceneStatusOMNIX1 status) {
  if (scene_->status == status) return;
  scene_->status = status;
  scene_->ever_ready = scene_->ever_ready || status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1;
  const XrEventDataHapticSceneStateChangedOMNIX1 changed{XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1,
                                                         nullptr,
                                                         scene_->session,
                                                         scene_->handle,
                                                         status,
                                                         clock_.ToXr(base::MonotonicNow_ns())};
  events_.Push(changed);
}

bool HapticScenes::IsOfDestroyed(const XrEventDataBuffer& event) const {
  if (event.type != XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1) return false;
  XrEventDataHapticSceneStateChangedOMNIX1 changed;
  std::memcpy(&changed, &event, sizeof(changed));
  return !Contains(changed.scene);
}

void HapticScenes::HandleUpdates() {
  struct News {
    bool connected = false;
    std::uint64_t welcomes = 0;
    std::vector<client::HapticSceneUpdate> updates;
  };
  News news = link_.WithConnection([](client::Connection& connection) {
    return News{connection.connected(), connection.welcomes(), connection.PopHapticSceneUpdates()};
  });
  const bool failed = scene_->status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1;
  if (!failed && scene_->sent != 0 && (!news.connected || scene_->sent != news.welcomes)) {
    scene_->sent = 0;  // the service has forgotten it, or is gone
    scene_->state = {};
    scene_->surfaces.clear();
    SetStatus(XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
  }
  for (client::HapticSceneUpdate& update : news.updates) {
    if (update.is_table) {
      if (update.table.number == scene_->number) scene_->table = std::move(update.table);
      continue;
    }
    if (failed) continue;
    if (update.state.number != scene_->number || scene_->sent != news.welcomes) continue;
    if (update.state.generation != scene_->state.generation) scene_->surfaces.clear();
    scene_->state = update.state;
    scene_->text = std::move(update.text);
    SetStatus(ToStatus(update.state.status));
  }
}

// All of it, once per connection: what cannot be sent is retried at the next poll.
void HapticScenes::NotifyAll() {
  if (scene_->status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1) return;
  scene_->sent = link_.WithConnection([this](client::Connection& connection) -> std::uint64_t {
    if (!connection.connected() || scene_->sent == connection.welcomes()) return scene_->sent;
    protocol::HapticSceneLoad load;
    load.number = scene_->number;
    load.flags = scene_->flags;
    load.bytes = scene_->bytes;
    load.scale = scene_->placement ? scene_->placement->scale : 1;
    if (!connection.Send(load, scene_->document.get())) return 0;
    bool sent = !scene_->placement || connection.Send(scene_->place);
    protocol::HapticNodes nodes;
    nodes.number = scene_->number;
    nodes.t_ns = scene_->nodes_t_ns;
    for (const auto& [object, pose] : scene_->nodes) nodes.nodes[nodes.count++] = pose;
    sent = sent && (nodes.count == 0 || connection.Send(nodes));
    for (const auto& [index, parameters] : scene_->changed) {
      protocol::HapticMaterial material;
      material.number = scene_->number;
      material.material = index;
      material.parameters = parameters;
      sent = sent && connection.Send(material);
    }
    protocol::HapticSceneEnable enable;
    enable.number = scene_->number;
    enable.enabled = scene_->enabled ? 1 : 0;
    sent = sent && connection.Send(enable);
    if (scene_->surfaces_asked) connection.RequestSurfaces(true);
    return sent ? connection.welcomes() : 0;
  });
}

}  // namespace omni::layer
