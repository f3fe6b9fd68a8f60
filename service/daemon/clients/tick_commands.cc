#include "service/daemon/clients/tick_commands.h"

#include <utility>

namespace omni::daemon {

const base::InputMapping& TickCommands::MappingOf(const Client* owner) const {
  const bool own = owner != nullptr && owner->app != nullptr && owner->app->inputs;
  return own ? owner->app->inputs->mapping : fallback_;
}

void TickCommands::Write(std::int64_t now_ns, Force force, bool idle) {
  lives_.Give(std::move(force.life));
  commands_ = {
      .t_ns = now_ns,
      .gate = force.owner != nullptr && force.allowed ? loop::ForceGate::kOpen : loop::ForceGate::kClosed,
      .owner = {.page = lives_.newest().get(), .number = lives_.number()},
      .idle = idle,
      .scene_generation = scenes_.generation(),
      .force_scale = force.owner == nullptr || force.owner->app == nullptr ? 1.0 : force.owner->app->force_scale,
      .haptic = vibration_.waveform(),
      .inputs = MappingOf(force.owner),
      .applied = force.applied,
      .scene = scenes_.ControlOf(force.owner == nullptr ? 0 : force.owner->info.id)};
  device_.WithLoop([this](loop::TickThread& loop) {
    const BuiltScene* scene = scenes_.felt();
    loop.scenes().Write({.scene = scene == nullptr ? nullptr : scene->scene.get(),
                         .generation = scenes_.generation(),
                         .build = scene == nullptr ? 0 : scene->build});
    if (vibration_.PopFresh()) loop.vibration().Write(vibration_.samples());  // before the command that names them
    loop.commands().Write(commands_);
  });
}

void TickCommands::CloseGate() {
  commands_.gate = loop::ForceGate::kClosed;
  commands_.applied.open = false;
  device_.WithLoop([this](loop::TickThread& loop) { loop.commands().Write(commands_); });
}

}  // namespace omni::daemon
